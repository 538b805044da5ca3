// SPDX-License-Identifier: GPL-3.0-or-later
// Single scattering among density grids without bias: random points of a ray, and transmittances that are right on average.
// Based on: Novak, Selle and Jarosz, Residual Ratio Tracking for Estimating Attenuation in Participating Media, ACM Trans.
//           Graph. 33(6), 2014: ratio tracking.
// Differs:  a majorant per brick of 8^3 voxels, and none where there is no density; which parts of the ray are lit is
//           known exactly, so that no point is spent on finding it out.
// Bound:    32 points per ray and light sample, with as many lookups each as the light's way is optically deep where it
//           is densest. Noise falls with the square root of the passes; March has less error in less time.
#pragma once
#include "light_shafts/visibility.hpp"
#include "scene/media.hpp"

namespace tyndall::light_shafts {
/// Rays with their media and what is lit of them, whether in media or in the light's cone or not.
struct TrackedRays {
    std::span<const ViewRay> rays;
    std::span<const std::uint32_t> first_segment; ///< Ray r has segments[first_segment[r] .. first_segment[r + 1]).
    std::span<const MediumSegment> segments;
    const LitRows& lit;
};
/// Overwrites the radiance that each ray gets of a light sample, and, unless its span is empty, what it would get if
/// nothing cast a shadow.
void track_ratios(const Media& media, const LightSample& light, std::uint32_t seed, const TrackedRays& tracked,
                  std::span<Rgb> radiance, std::span<Rgb> unshadowed);
} // namespace tyndall::light_shafts
