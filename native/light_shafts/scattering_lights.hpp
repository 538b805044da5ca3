// SPDX-License-Identifier: GPL-3.0-or-later
// The lights of a scene as samples without a size, each with its share of the strength; and why others are left out.
#pragma once
#include "light_shafts/light_shafts.hpp"
#include <vector>

namespace tyndall::light_shafts {
/// Samples of one light (or of the world) whose sum is the light.
struct ScatteringLight {
    std::string name;
    std::vector<LightSample> samples;
};

/// Point `index` of `count` that fill the unit cube evenly: the Hammersley set, shifted by the seed. The first two numbers
/// are strata at any power of two.
[[nodiscard]] vec3 stratum(std::uint32_t index, std::uint32_t count, std::uint32_t seed);

/// Lights that can scatter in some medium, in the scene's order, the world last. Reports what is left out and why.
[[nodiscard]] std::vector<ScatteringLight> find_scattering_lights(const Scene& scene, const Media& media,
                                                                  const Config& config, Statistics& statistics);
} // namespace tyndall::light_shafts
