// SPDX-License-Identifier: GPL-3.0-or-later
// Whether the world's light comes from as many directions as fog needs that scatters forward.
// Based on: the solid angle of Henyey and Greenstein's peak, about (1 - |g|)^2: what fewer directions than a dozen of these
//           leave out, no sample of a pixel finds.
#pragma once
#include "light_shafts/light_shafts.hpp"
#include <optional>
#include <string>

namespace tyndall::light_shafts {
/// With the fog that is farthest from it.
struct LackOfDirections {
    float asymmetry_g; ///< Its absolute value.
    double wanted;     ///< Directions that would do.
    /// Less forward fog gains less by draws than they take, in a viewport's few samples above all.
    [[nodiscard]] bool is_worth_draws() const { return asymmetry_g >= 0.8f; }
};
/// Nothing: config.world_samples suffice, or the world lights no fog.
[[nodiscard]] std::optional<LackOfDirections> lack_of_directions(const Scene& scene, const Config& config);
/// For a report where the light is not drawn instead.
[[nodiscard]] std::string described(const LackOfDirections& lack, const Scene& scene, const Config& config);
} // namespace tyndall::light_shafts
