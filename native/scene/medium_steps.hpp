// SPDX-License-Identifier: GPL-3.0-or-later
// A ray through media of which some are modulated by density grids, in steps over which all of them are even enough.
// Bound:    the densities' means and the optical depths of the steps are exact (density_walk.hpp); what steps cost is
//           that a mean stands for the density within one, of second order in its length.
#pragma once
#include "scene/media.hpp"

namespace tyndall {
/// The mean density of a grid's channel over a step.
struct GridShare {
    std::uint16_t grid; ///< Into GridMedia::all.
    std::uint16_t channel;
    float density;
};
struct MediumStep {
    float near_m, far_m;
    std::uint32_t segment; ///< Into the ray's segments: its homogeneous media.
    Rgb depth_gain{0.0f};  ///< Optical depth from near to far, of all media.
    std::uint32_t first_share = 0, share_count = 0;
};
/// Of one ray after another.
struct MediumSteps {
    std::vector<MediumStep> steps;
    std::vector<GridShare> shares;
    std::vector<std::uint32_t> first{0}; ///< Ray r owns steps[first[r] .. first[r + 1]).
    void clear() {
        steps.clear(), shares.clear();
        first.assign(1, 0);
    }
    void end_ray() { first.push_back(static_cast<std::uint32_t>(steps.size())); }
    [[nodiscard]] std::span<const MediumStep> of_ray(std::size_t ray) const {
        return std::span(steps).subspan(first[ray], first[ray + 1] - first[ray]);
    }
    [[nodiscard]] std::span<const GridShare> shares_of(const MediumStep& step) const {
        return std::span(shares).subspan(step.first_share, step.share_count);
    }
};
struct StepLimits {
    float length_voxels = 4.0f; ///< Of a step among a grid's density.
    float depth_gain = 0.25f;   ///< Optical depth of such a step, in its densest channel.
};

/// Appends the steps of a ray, near to far, and ends it; they cover its `segments` (of Media::segments, made finite),
/// up to where less than 1e-9 of the light would be left.
void append_steps(const Media& media, const Ray& ray, std::span<const MediumSegment> segments, const StepLimits& limits,
                  MediumSteps& steps);

/// Appends `homogeneous` and what of `dense` lies outside of them, near to far. `homogeneous` rise and do not overlap.
void append_union(std::span<const MediumSegment> homogeneous, std::span<const LinePart> dense,
                  std::vector<MediumSegment>& segments);
} // namespace tyndall
