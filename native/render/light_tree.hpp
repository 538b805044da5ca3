// SPDX-License-Identifier: GPL-3.0-or-later
// One of many lights for a point, drawn about as often as it is bright there.
// Based on: Conty Estevez and Kulla, Importance Sampling of Many Lights with Adaptive Tree Splitting, HPG 2018: boxes and
//           cones around lights, their surface area orientation heuristic, and what a cluster may send to a point.
// Differs:  eight children a node, asked side by side: a third of the levels, each of which chooses among more. A leaf is one
//           light. Cones have a back, too: what glows on both sides need not count as shining all around. Nothing is split:
//           a pixel's draws are one low-discrepancy sequence, which deals them to the lights as splitting would.
// Bound:    some 90 ns a draw of 10,000 lights; 60 bytes a light.
#pragma once
#include "core/math.hpp"
#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace tyndall::render {
/// Where lights are and where they shine to. Its light leaves within `reach_rad` of directions that lie within `spread_rad`
/// of the axis, and falls with the cosine of how far it is from these.
struct LightBounds {
    Bounds3 box;
    vec3 axis{0, 0, 1};      ///< Unit.
    float spread_rad = 0.0f; ///< [0, pi]
    float reach_rad = 0.0f;  ///< [0, pi / 2]
    float power = 0.0f;      ///< Intensity in the best direction, W/sr: of several lights together.
    float back = 0.0f;       ///< The same around -axis, times this: [0, 1].
    [[nodiscard]] bool operator==(const LightBounds&) const = default;
};

class LightTree {
public:
    LightTree() = default;
    /// Those without power are never chosen.
    explicit LightTree(std::span<const LightBounds> lights);

    struct Choice {
        std::uint32_t light = none;
        float probability = 0.0f;
    };
    static constexpr std::uint32_t none = ~0u;
    /// A light that may shine on a surface there with that unit normal, by a number in [0, 1). Nothing: none does.
    [[nodiscard]] Choice choose(const vec3& point, const vec3& normal, float u) const;
    /// A stretch of a view ray, whose media let exp(-sigma_t_per_m * distance) of the light pass in the mean.
    struct Line {
        vec3 origin, direction; ///< The latter unit.
        float near_m, far_m;    ///< near < far < infinity
        float sigma_t_per_m = 0.0f;
    };
    /// A light that may shine on some of its points, by a number in [0, 1); see light_tree_along.cpp.
    [[nodiscard]] Choice choose_along(const Line& line, float u) const;
    /// With which choose_along() returns that light.
    [[nodiscard]] float probability_along(std::uint32_t light, const Line& line) const;
    /// With which choose() returns that light.
    [[nodiscard]] float probability(std::uint32_t light, const vec3& point, const vec3& normal) const;
    [[nodiscard]] bool is_empty() const { return nodes_.empty(); }
    [[nodiscard]] std::size_t bytes() const {
        return nodes_.size() * (sizeof(Node) + sizeof(Place)) + place_of_light_.size() * sizeof(Place);
    }

    static constexpr std::size_t width = 8;
    using Row = std::array<float, width>;
    struct alignas(32) Node {
        Row x{}, y{}, z{};       ///< Centre of the children's spheres.
        Row radius2{}, floor2{}; ///< Of these; squared distance nearer than which nothing counts as.
        Row axis_x{}, axis_y{}, axis_z{};
        Row cos_spread{}, sin_spread{}, cos_reach{};
        Row power{}; ///< 0: no child.
        Row back{};
        std::array<std::uint32_t, width> child{}; ///< Index of a node; with is_light, of a light.
    };
    static constexpr std::uint32_t is_light = 0x8000'0000u;
    /// A child of a node, and a number in [0, 1) to choose below it by.
    struct Slot {
        std::size_t slot;
        float rest;
    };
    /// That of the weights, which add up to `sum`, in which `u` of the sum lies.
    [[nodiscard]] static Slot slot_at(const Row& weights, float sum, float u) {
        const float target = u * sum;
        float before = 0.0f;
        std::size_t chosen = width;
        for (std::size_t slot = 0; slot < width; ++slot) {
            if (!(weights[slot] > 0.0f))
                continue;
            if (chosen != width && target < before)
                break;
            chosen = slot; // the last one that is bright takes what rounding leaves
            before += weights[slot];
        }
        const float weight = weights[chosen];
        return {chosen, std::min(std::max((target - (before - weight)) / weight, 0.0f), 0x1.fffffep-1f)};
    }

private:
    /// Into nodes_, and which of its children.
    struct Place {
        std::uint32_t node = none, slot = 0;
    };
    class Builder;            // light_tree_build.cpp
    std::vector<Node> nodes_; ///< The root first.
    std::vector<Place> place_of_light_, place_of_node_;
};
} // namespace tyndall::render
