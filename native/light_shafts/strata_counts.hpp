// SPDX-License-Identifier: GPL-3.0-or-later
// How many strata each light of a frame is worth: a pilot with a few of them along a few rays tells how much they differ.
// Based on: the error of a stratified mean in two dimensions, which falls as n^-0.75 where the integrand has edges
//           (Mitchell, Consequences of Stratified Sampling in Graphics, SIGGRAPH 1996): between random and smooth.
// Differs:  lights share the frame's error evenly, as independent errors add up; rows of the pilot are coarse, and finer
//           for a light as long as their own error decides how many strata it gets.
// Bound:    256 rays, 4 strata per light and 16 of the world, rows of 32 and 64 lines, of 64 and 128 for suns and
//           edited lights; where these do not agree on the number, of 128, and unless it is a draft 256.
#pragma once
#include "light_shafts/scattering_lights.hpp"
#include <functional>

namespace tyndall::light_shafts {
/// Of the first picture of a series, for the others: strata that are dealt out are the same in all of them. A light that is
/// dark at first is counted in the first picture that it shines in.
class KeptStrata {
public:
    /// Those that serve a part of a series in which the lights of shining_lights() shine, or what `count` finds.
    const StrataCounts& counts(const SeriesPart& part, const std::vector<bool>& shining,
                               const std::function<StrataCounts()>& count);

private:
    StrataCounts counts_;
    std::vector<bool> counted_;
};

/// Which lights of a scene could light the air now, the world last.
[[nodiscard]] std::vector<bool> shining_lights(const Scene& scene);

/// For `rays` that are clipped to the media. Without config.adapts_strata: the numbers of the configuration. Throws
/// Cancelled.
[[nodiscard]] StrataCounts count_strata(const Scene& scene, const Media& media, const View& view,
                                        std::span<const ViewRay> rays, const Config& config, Progress& progress);
/// The least power of two, at most `most`, whose stratified mean of values with this standard deviation has this error.
[[nodiscard]] std::uint32_t strata_for_error(double deviation, double error, std::uint32_t most);
} // namespace tyndall::light_shafts
