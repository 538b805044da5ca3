// SPDX-License-Identifier: GPL-3.0-or-later
// How the lights of light_tree.hpp come into its nodes.
// Based on: section 4.3 of the paper: the surface area orientation heuristic, equations 1 and 2, in bins; cones around
//           cones, its algorithm 1.
// Differs:  a node's eight children come of seven splits, of that part each time which costs most.
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

Part part_of(std::span<const LightBounds> lights, std::span<std::uint32_t> members, float least_m) {
    LightBounds bounds;
    for (const std::uint32_t member : members)
        bounds = united(bounds, lights[member]);
    return {members, bounds, cost_of(bounds, least_m)};
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
        std::array<LightBounds, bin_count> bins{};
        for (const std::uint32_t member : part.members) {
            const float place = (lights[member].box.centre()[axis] - centres.min[axis]) / size[axis];
            LightBounds& bin = bins[std::min(static_cast<std::size_t>(place * bin_count), bin_count - 1)];
            bin = united(bin, lights[member]);
        }
        std::array<float, bin_count> above{};
        LightBounds side;
        for (std::size_t bin = bin_count - 1; bin > 0; --bin) {
            side = united(side, bins[bin]);
            above[bin] = cost_of(side, least_m);
        }
        side = {};
        for (std::size_t bin = 0; bin + 1 < bin_count; ++bin) {
            side = united(side, bins[bin]);
            const float cost = (cost_of(side, least_m) + above[bin + 1]) * longest / size[axis];
            if (!(side.power > 0.0f) || !(above[bin + 1] > 0.0f) || (best && best->cost <= cost))
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

std::uint32_t LightTree::build(std::span<const LightBounds> lights, std::span<std::uint32_t> members) {
    const auto index = static_cast<std::uint32_t>(nodes_.size());
    nodes_.emplace_back();
    place_of_node_.emplace_back();
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
        put(part.bounds, nodes_[index], slot);
        const Place here{index, slot};
        if (part.members.size() == 1) {
            nodes_[index].child[slot] = part.members.front() | is_light;
            place_of_light_[part.members.front()] = here;
            continue;
        }
        const std::uint32_t below = build(lights, part.members);
        nodes_[index].child[slot] = below;
        place_of_node_[below] = here;
    }
    return index;
}

LightTree::LightTree(std::span<const LightBounds> lights) : place_of_light_(lights.size()) {
    std::vector<std::uint32_t> members;
    for (std::uint32_t light = 0; light < lights.size(); ++light)
        if (lights[light].power > 0.0f)
            members.push_back(light);
    if (!members.empty())
        build(lights, members);
}
} // namespace tyndall::render
