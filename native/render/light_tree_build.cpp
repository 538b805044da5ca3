// SPDX-License-Identifier: GPL-3.0-or-later
// How the lights of light_tree.hpp come into its nodes.
// Based on: section 4.3 of the paper: the surface area orientation heuristic, equation 2, in bins.
// Differs:  a node's eight children come of seven splits, of that part each time which costs most. Where many lights are
//           split, some of them tell where.
// Bound:    two passes over the lights for each level of the binary tree, one of them into 36 bins where they are few.
#include "core/parallel.hpp"
#include "render/light_cluster.hpp"
#include "render/light_tree.hpp"
#include <algorithm>
#include <array>

namespace tyndall::render {
namespace splitting {
struct Part {
    std::span<std::uint32_t> members;
    LightCluster bounds;
    Bounds3 centres; ///< Of their boxes.
    float cost;
};

constexpr std::size_t bin_count = 12;
/// Of more lights so many tell where they are split.
constexpr std::size_t most_asked = 2048;

/// Narrower than cones around the cones of bins.
LightCluster bounds_of(std::span<const LightBounds> lights, std::span<const std::uint32_t> members) {
    const auto united = [&](std::size_t begin, std::size_t end) {
        LightCluster bounds;
        for (const std::uint32_t member : members.subspan(begin, end - begin))
            bounds += LightCluster(lights[member]);
        return bounds;
    };
    constexpr std::size_t block = 16384;
    return members.size() <= block ? united(0, members.size())
                                   : parallel_sum(members.size(), block, LightCluster(), Progress{}, united);
}

Bounds3 centres_of(std::span<const LightBounds> lights, std::span<const std::uint32_t> members) {
    Bounds3 centres;
    for (const std::uint32_t member : members)
        centres.grow(lights[member].box.centre());
    return centres;
}

/// Between which bins, and what lies on either side.
struct Split {
    int axis = -1; ///< Below 0: they stand in one place.
    std::size_t end_bin = 0;
    LightCluster low, high;
};

class Splitter {
public:
    /// The size of what is split is the measure of what lies in it.
    Splitter(std::span<const LightBounds> lights, const Part& whole)
        : lights_(lights), least_m_(1e-3f * whole.bounds.box.diagonal_m()) {}

    [[nodiscard]] std::pair<Part, Part> halves_of(const Part& part) {
        if (part.members.size() == 2)
            return {part_of(part.members.first(1)), part_of(part.members.last(1))};
        const Split split = best_split(part);
        if (split.axis < 0) {
            const std::size_t half = part.members.size() / 2;
            return {part_of(part.members.first(half)), part_of(part.members.subspan(half))};
        }
        Part low{.members = {}, .bounds = split.low, .centres = {}, .cost = split.low.cost(least_m_)};
        Part high{.members = {}, .bounds = split.high, .centres = {}, .cost = split.high.cost(least_m_)};
        std::size_t low_count = 0;
        above_.clear();
        for (const std::uint32_t member : part.members) {
            const vec3 centre = lights_[member].box.centre();
            if (bin_of(part, split.axis, centre) < split.end_bin) {
                low.centres.grow(centre);
                part.members[low_count++] = member;
            } else {
                high.centres.grow(centre);
                above_.push_back(member);
            }
        }
        low.members = part.members.first(low_count);
        high.members = part.members.subspan(low_count);
        std::ranges::copy(above_, high.members.begin());
        return {low, high};
    }

private:
    [[nodiscard]] Part part_of(std::span<std::uint32_t> members) const {
        Part part{.members = members,
                  .bounds = bounds_of(lights_, members),
                  .centres = centres_of(lights_, members),
                  .cost = 0.0f};
        part.cost = part.bounds.cost(least_m_);
        return part;
    }

    [[nodiscard]] static std::size_t bin_of(const Part& part, int axis, const vec3& centre) {
        const float place = (centre[axis] - part.centres.min[axis]) / (part.centres.max[axis] - part.centres.min[axis]);
        return std::min(static_cast<std::size_t>(place * bin_count), bin_count - 1);
    }

    /// Where the two sides cost least together: equation 2, with the factor for thin parts.
    [[nodiscard]] Split best_split(const Part& part) const {
        const vec3 size = part.centres.max - part.centres.min;
        const float longest = std::max({size.x, size.y, size.z});
        std::array<bool, 3> is_wide{};
        for (int axis = 0; axis < 3; ++axis)
            is_wide[static_cast<std::size_t>(axis)] = size[axis] > 1e-6f * longest && size[axis] > 0.0f;
        std::array<std::array<LightCluster, bin_count>, 3> bins; // of each axis
        const std::size_t stride = std::max<std::size_t>(1, part.members.size() / most_asked);
        for (std::size_t index = stride / 2; index < part.members.size(); index += stride) {
            const LightCluster light(lights_[part.members[index]]);
            const vec3 centre = light.box.centre();
            for (int axis = 0; axis < 3; ++axis)
                if (is_wide[static_cast<std::size_t>(axis)])
                    bins[static_cast<std::size_t>(axis)][bin_of(part, axis, centre)] += light;
        }
        Split best;
        float least_cost = 0.0f;
        for (int axis = 0; axis < 3; ++axis) {
            if (!is_wide[static_cast<std::size_t>(axis)])
                continue;
            const std::array<LightCluster, bin_count>& of_axis = bins[static_cast<std::size_t>(axis)];
            std::array<LightCluster, bin_count> above; // that bin and all beyond
            above.back() = of_axis.back();
            for (std::size_t bin = bin_count - 1; bin-- > 1;) {
                above[bin] = above[bin + 1];
                above[bin] += of_axis[bin];
            }
            LightCluster below;
            for (std::size_t bin = 0; bin + 1 < bin_count; ++bin) {
                if (of_axis[bin].is_empty()) // a split here costs what that before it did
                    continue;
                below += of_axis[bin];
                if (above[bin + 1].is_empty())
                    break;
                const float cost = (below.cost(least_m_) + above[bin + 1].cost(least_m_)) * longest / size[axis];
                if (best.axis >= 0 && least_cost <= cost)
                    continue;
                best = {axis, bin + 1, below, above[bin + 1]};
                least_cost = cost;
            }
        }
        best.low.power *= static_cast<float>(stride), best.high.power *= static_cast<float>(stride);
        return best;
    }

    std::span<const LightBounds> lights_;
    float least_m_;
    std::vector<std::uint32_t> above_; ///< While a part is split.
};

void put(const LightCluster& bounds, LightTree::Node& node, std::size_t slot) {
    const vec3 centre = bounds.box.centre();
    const float radius_m = 0.5f * bounds.box.diagonal_m();
    node.x[slot] = centre.x, node.y[slot] = centre.y, node.z[slot] = centre.z;
    node.radius2[slot] = 1.00001f * radius_m * radius_m;
    // Rounding of a light without a size that touches the point must not hide all others for good.
    node.floor2[slot] = std::max(node.radius2[slot], 1e-12f * (1.0f + glm::dot(centre, centre)));
    node.axis_x[slot] = bounds.axis.x, node.axis_y[slot] = bounds.axis.y, node.axis_z[slot] = bounds.axis.z;
    node.cos_spread[slot] = bounds.cos_spread;
    node.sin_spread[slot] = bounds.sin_spread;
    node.cos_reach[slot] = std::max(0.0f, bounds.cos_reach);
    node.power[slot] = bounds.power;
    node.back[slot] = bounds.back;
}
} // namespace splitting

class LightTree::Builder {
    using Part = splitting::Part;

public:
    Builder(std::span<const LightBounds> lights, LightTree& tree) : lights_(lights), tree_(tree) {}

    void grow(std::span<std::uint32_t> members) {
        // By their number alone, so that threads change nothing. Fewer lights have one branch, in place.
        const std::size_t most_of_bud = members.size() < 16384 ? 0 : members.size() / 64;
        Branch trunk;
        std::vector<Bud> buds, none_left;
        grow({members, splitting::bounds_of(lights_, members), splitting::centres_of(lights_, members), 0.0f}, trunk,
             most_of_bud, buds);
        tree_.nodes_ = std::move(trunk.nodes);
        tree_.place_of_node_ = std::move(trunk.place_of_node);
        std::vector<Branch> branches(buds.size());
        parallel_for(
            buds.size(), Progress{}, [&](std::size_t bud) { grow(buds[bud].part, branches[bud], 0, none_left); }, 1);
        for (std::size_t bud = 0; bud < buds.size(); ++bud)
            append(branches[bud], buds[bud].place);
    }

private:
    /// A part of the tree: its nodes are counted from its own first one.
    struct Branch {
        std::vector<Node> nodes;
        std::vector<Place> place_of_node;
    };
    /// Lights that a branch of their own goes to, and where that hangs.
    struct Bud {
        Part part;
        Place place;
    };

    /// Returns the index of its node. What has no more lights than `most_of_bud` is left to `buds`. Bounds and centres of
    /// the whole are its own.
    std::uint32_t grow(const Part& whole, Branch& branch, std::size_t most_of_bud, std::vector<Bud>& buds) {
        const auto index = static_cast<std::uint32_t>(branch.nodes.size());
        branch.nodes.emplace_back();
        branch.place_of_node.emplace_back();
        splitting::Splitter splitter(lights_, whole);
        std::vector<Part> parts{whole};
        while (parts.size() < width) {
            const auto costliest = std::ranges::max_element(
                parts, {}, [](const Part& part) { return part.members.size() > 1 ? part.cost : -1.0f; });
            if (costliest->members.size() < 2)
                break;
            auto [low, high] = splitter.halves_of(*costliest);
            *costliest = low;
            parts.push_back(high);
        }
        for (std::uint32_t slot = 0; slot < parts.size(); ++slot) {
            Part& part = parts[slot];
            part.bounds = splitting::bounds_of(lights_, part.members);
            splitting::put(part.bounds, branch.nodes[index], slot);
            const Place here{index, slot};
            if (part.members.size() == 1) {
                branch.nodes[index].child[slot] = part.members.front() | is_light;
                tree_.place_of_light_[part.members.front()] = here;
                continue;
            }
            if (part.members.size() <= most_of_bud) {
                buds.push_back({part, here});
                continue;
            }
            const std::uint32_t below = grow(part, branch, most_of_bud, buds);
            branch.nodes[index].child[slot] = below;
            branch.place_of_node[below] = here;
        }
        return index;
    }

    void append(const Branch& branch, const Place& place) {
        const auto first = static_cast<std::uint32_t>(tree_.nodes_.size());
        tree_.nodes_[place.node].child[place.slot] = first;
        for (std::size_t index = 0; index < branch.nodes.size(); ++index) {
            Node node = branch.nodes[index];
            for (std::size_t slot = 0; slot < width; ++slot) {
                if (!(node.power[slot] > 0.0f))
                    continue;
                if ((node.child[slot] & is_light) != 0)
                    tree_.place_of_light_[node.child[slot] & ~is_light].node += first;
                else
                    node.child[slot] += first;
            }
            tree_.nodes_.push_back(node);
            const Place above = branch.place_of_node[index];
            tree_.place_of_node_.push_back(index == 0 ? place : Place{above.node + first, above.slot});
        }
    }

    std::span<const LightBounds> lights_;
    LightTree& tree_;
};

LightTree::LightTree(std::span<const LightBounds> lights) : place_of_light_(lights.size()) {
    std::vector<std::uint32_t> members;
    for (std::uint32_t light = 0; light < lights.size(); ++light)
        if (lights[light].power > 0.0f)
            members.push_back(light);
    if (!members.empty())
        Builder(lights, *this).grow(members);
}
} // namespace tyndall::render
