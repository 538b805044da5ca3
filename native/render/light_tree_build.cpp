// SPDX-License-Identifier: GPL-3.0-or-later
// How the lights of light_tree.hpp come into its nodes.
// Based on: section 4.3 of the paper: the surface area orientation heuristic, equations 1 and 2, in bins; cones around
//           cones, its algorithm 1.
// Differs:  a node's eight children come of seven splits, of that part each time which costs most.
#include "core/parallel.hpp"
#include "render/light_tree.hpp"
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

namespace tyndall::render {

static float angle_between(const vec3& a, const vec3& b) {
    return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

/// `b`'s axis may be turned round where its back shines as its front.
static void unite_cones(LightBounds& result, const LightBounds& a, const LightBounds& b) {
    const vec3 other = b.back == 1.0f && glm::dot(a.axis, b.axis) < 0.0f ? -b.axis : b.axis;
    const float between = angle_between(a.axis, other);
    if (std::min(between + b.spread_rad, pi) <= a.spread_rad) {
        result.axis = a.axis;
        result.spread_rad = a.spread_rad;
    } else if (std::min(between + a.spread_rad, pi) <= b.spread_rad) {
        result.axis = other;
        result.spread_rad = b.spread_rad;
    } else {
        const float spread = 0.5f * (a.spread_rad + between + b.spread_rad);
        const vec3 across = other - glm::dot(a.axis, other) * a.axis;
        const float sine = glm::length(across);
        if (spread >= pi || !(sine > 1e-6f)) {
            result.axis = a.axis;
            result.spread_rad = spread >= pi || between > 0.5f * pi ? pi : spread;
        } else {
            const float turn = spread - a.spread_rad;
            result.axis = glm::normalize(std::cos(turn) * a.axis + std::sin(turn) / sine * across);
            result.spread_rad = spread;
        }
    }
}

LightBounds united(const LightBounds& a, const LightBounds& b) {
    if (!(a.power > 0.0f))
        return b;
    if (!(b.power > 0.0f))
        return a;
    LightBounds result = a;
    result.box.grow(b.box);
    result.reach_rad = std::max(a.reach_rad, b.reach_rad);
    result.power = a.power + b.power;
    result.back = std::max(a.back, b.back);
    if (a.back == 1.0f && b.back != 1.0f)
        unite_cones(result, b, a);
    else
        unite_cones(result, a, b);
    return result;
}

namespace {
/// Equation 1 of the paper, up to a factor: what a part costs. `least_m` keeps lights without a size apart.
float cost_of(const LightBounds& bounds, float least_m) {
    if (!(bounds.power > 0.0f))
        return 0.0f;
    const vec3 size = bounds.box.max - bounds.box.min + vec3(least_m);
    const float area = size.x * size.y + size.y * size.z + size.z * size.x;
    const float spread = bounds.spread_rad, widest = std::min(spread + bounds.reach_rad, pi);
    const float directions = 2.0f * pi * (1.0f - std::cos(spread)) +
                             0.5f * pi *
                                 (2.0f * widest * std::sin(spread) - std::cos(spread - 2.0f * widest) -
                                  2.0f * spread * std::sin(spread) + std::cos(spread));
    return bounds.power * area * std::max(directions, 0.1f) * (1.0f + bounds.back);
}

struct Part {
    std::span<std::uint32_t> members;
    LightBounds bounds;
    float cost;
};

/// united(), light after light. Most lie in the cone of those before them: a cosine says so, without an angle.
class Union {
public:
    void add(const LightBounds& light) {
        if (!(bounds_.power > 0.0f)) {
            bounds_ = light;
            cos_spread_ = std::cos(light.spread_rad);
        } else if (light.spread_rad == 0.0f && light.power > 0.0f && contains(light)) {
            bounds_.box.grow(light.box);
            bounds_.reach_rad = std::max(bounds_.reach_rad, light.reach_rad);
            bounds_.power += light.power;
            bounds_.back = std::max(bounds_.back, light.back);
        } else {
            bounds_ = united(bounds_, light);
            cos_spread_ = std::cos(bounds_.spread_rad);
        }
    }
    [[nodiscard]] const LightBounds& bounds() const { return bounds_; }

private:
    /// Rounding leaves those out that lie at the cone's border: united() takes them.
    [[nodiscard]] bool contains(const LightBounds& light) const {
        constexpr float rounding = 1e-6f;
        if (bounds_.spread_rad >= pi)
            return true;
        const float cosine = glm::dot(bounds_.axis, light.axis);
        return (std::max(bounds_.back, light.back) == 1.0f ? std::abs(cosine) : cosine) > cos_spread_ + rounding;
    }
    LightBounds bounds_;
    float cos_spread_ = 1.0f;
};

Part part_of(std::span<const LightBounds> lights, std::span<std::uint32_t> members, float least_m) {
    Union all;
    for (const std::uint32_t member : members)
        all.add(lights[member]);
    return {members, all.bounds(), cost_of(all.bounds(), least_m)};
}

struct Split {
    int axis;
    float at_m, cost;
};

/// Where the two sides cost least together: equation 2, with the factor for thin parts.
std::optional<Split> best_split(std::span<const LightBounds> lights, const Part& part, float least_m) {
    constexpr std::size_t bin_count = 12;
    Bounds3 centres;
    for (const std::uint32_t member : part.members)
        centres.grow(lights[member].box.centre());
    const vec3 size = centres.max - centres.min;
    const float longest = std::max({size.x, size.y, size.z});
    std::optional<Split> best;
    for (int axis = 0; axis < 3; ++axis) {
        if (!(size[axis] > 1e-6f * longest) || !(size[axis] > 0.0f))
            continue;
        std::array<Union, bin_count> bins{};
        for (const std::uint32_t member : part.members) {
            const float place = (lights[member].box.centre()[axis] - centres.min[axis]) / size[axis];
            bins[std::min(static_cast<std::size_t>(place * bin_count), bin_count - 1)].add(lights[member]);
        }
        const auto is_empty = [&](std::size_t bin) { return !(bins[bin].bounds().power > 0.0f); };
        std::array<float, bin_count> above{};
        LightBounds side;
        for (std::size_t bin = bin_count - 1; bin > 0; --bin) {
            side = united(side, bins[bin].bounds());
            above[bin] = !is_empty(bin) ? cost_of(side, least_m) : bin + 1 < bin_count ? above[bin + 1] : 0.0f;
        }
        side = {};
        for (std::size_t bin = 0; bin + 1 < bin_count; ++bin) {
            if (is_empty(bin)) // a split here costs what that before it did
                continue;
            side = united(side, bins[bin].bounds());
            const float cost = (cost_of(side, least_m) + above[bin + 1]) * longest / size[axis];
            if (!(above[bin + 1] > 0.0f) || (best && best->cost <= cost))
                continue;
            best = {axis, centres.min[axis] + size[axis] * static_cast<float>(bin + 1) / bin_count, cost};
        }
    }
    return best;
}

std::pair<Part, Part> halves_of(std::span<const LightBounds> lights, const Part& part, float least_m) {
    auto middle = part.members.begin();
    if (const std::optional<Split> split = best_split(lights, part, least_m))
        middle = std::stable_partition(middle, part.members.end(), [&](std::uint32_t member) {
            return lights[member].box.centre()[split->axis] < split->at_m;
        });
    auto count = static_cast<std::size_t>(middle - part.members.begin());
    if (count == 0 || count == part.members.size())
        count = part.members.size() / 2; // they stand in one place
    return {part_of(lights, part.members.first(count), least_m), part_of(lights, part.members.subspan(count), least_m)};
}

void put(const LightBounds& bounds, LightTree::Node& node, std::size_t slot) {
    const vec3 centre = bounds.box.centre();
    const float radius_m = 0.5f * bounds.box.diagonal_m();
    node.x[slot] = centre.x, node.y[slot] = centre.y, node.z[slot] = centre.z;
    node.radius2[slot] = 1.00001f * radius_m * radius_m;
    // Rounding of a light without a size that touches the point must not hide all others for good.
    node.floor2[slot] = std::max(node.radius2[slot], 1e-12f * (1.0f + glm::dot(centre, centre)));
    node.axis_x[slot] = bounds.axis.x, node.axis_y[slot] = bounds.axis.y, node.axis_z[slot] = bounds.axis.z;
    node.cos_spread[slot] = std::cos(bounds.spread_rad);
    node.sin_spread[slot] = bounds.spread_rad >= pi ? 0.0f : std::sin(bounds.spread_rad);
    node.cos_reach[slot] = std::max(0.0f, std::cos(bounds.reach_rad));
    node.power[slot] = bounds.power;
    node.back[slot] = bounds.back;
}
} // namespace

std::uint32_t LightTree::grow(std::span<const LightBounds> lights, std::span<std::uint32_t> members, Branch& branch,
                              std::size_t most_of_bud, std::vector<Bud>& buds) {
    const auto index = static_cast<std::uint32_t>(branch.nodes.size());
    branch.nodes.emplace_back();
    branch.place_of_node.emplace_back();
    Bounds3 all;
    for (const std::uint32_t member : members)
        all.grow(lights[member].box);
    const float least_m = 1e-3f * all.diagonal_m();
    std::vector<Part> parts{part_of(lights, members, least_m)};
    while (parts.size() < width) {
        const auto costliest = std::ranges::max_element(
            parts, {}, [](const Part& part) { return part.members.size() > 1 ? part.cost : -1.0f; });
        if (costliest->members.size() < 2)
            break;
        auto [low, high] = halves_of(lights, *costliest, least_m);
        *costliest = low;
        parts.push_back(high);
    }
    for (std::uint32_t slot = 0; slot < parts.size(); ++slot) {
        const Part& part = parts[slot];
        put(part.bounds, branch.nodes[index], slot);
        const Place here{index, slot};
        if (part.members.size() == 1) {
            branch.nodes[index].child[slot] = part.members.front() | is_light;
            place_of_light_[part.members.front()] = here;
            continue;
        }
        if (part.members.size() <= most_of_bud) {
            buds.push_back({part.members, here});
            continue;
        }
        const std::uint32_t below = grow(lights, part.members, branch, most_of_bud, buds);
        branch.nodes[index].child[slot] = below;
        branch.place_of_node[below] = here;
    }
    return index;
}

void LightTree::append(const Branch& branch, const Place& place) {
    const auto first = static_cast<std::uint32_t>(nodes_.size());
    nodes_[place.node].child[place.slot] = first;
    for (std::size_t index = 0; index < branch.nodes.size(); ++index) {
        Node node = branch.nodes[index];
        for (std::size_t slot = 0; slot < width; ++slot) {
            if (!(node.power[slot] > 0.0f))
                continue;
            if ((node.child[slot] & is_light) != 0)
                place_of_light_[node.child[slot] & ~is_light].node += first;
            else
                node.child[slot] += first;
        }
        nodes_.push_back(node);
        const Place above = branch.place_of_node[index];
        place_of_node_.push_back(index == 0 ? place : Place{above.node + first, above.slot});
    }
}

LightTree::LightTree(std::span<const LightBounds> lights) : place_of_light_(lights.size()) {
    std::vector<std::uint32_t> members;
    for (std::uint32_t light = 0; light < lights.size(); ++light)
        if (lights[light].power > 0.0f)
            members.push_back(light);
    if (members.empty())
        return;
    // By their number alone, so that threads change nothing. Fewer lights have one branch, in place.
    const std::size_t most_of_bud = members.size() < 16384 ? 0 : members.size() / 64;
    Branch trunk;
    std::vector<Bud> buds, none_left;
    grow(lights, members, trunk, most_of_bud, buds);
    nodes_ = std::move(trunk.nodes);
    place_of_node_ = std::move(trunk.place_of_node);
    std::vector<Branch> branches(buds.size());
    parallel_for(
        buds.size(), Progress{}, [&](std::size_t bud) { grow(lights, buds[bud].members, branches[bud], 0, none_left); },
        1);
    for (std::size_t bud = 0; bud < buds.size(); ++bud)
        append(branches[bud], buds[bud].place);
}
} // namespace tyndall::render
