// SPDX-License-Identifier: GPL-3.0-or-later
// The lights of a scene as samples without a size, each with its share of the strength; and why others are left out.
#pragma once
#include "light_shafts/light_shafts.hpp"
#include "light_shafts/turning_disc.hpp"
#include <vector>

namespace tyndall::light_shafts {
/// Samples of one light (or of the world) whose sum is the light.
struct ScatteringLight {
    std::string name;
    std::size_t index; ///< Into Scene::lights; the world follows after the last one.
    std::vector<LightSample> samples;
    /// Of a lamp with something inside it: what its samples stand in, one each; `parts` of them make a stratum.
    std::vector<DiscCell> cells = {};
    std::size_t parts = 1;
    /// The share of a series' light that is here, see SeriesPart: the sum of the samples is the light all the same.
    float dealt_share = 1.0f;
};

/// Point `index` of `count` that fill the unit cube evenly: the Hammersley set, shifted by the seed. The first two numbers
/// are strata at any power of two.
[[nodiscard]] vec3 stratum(std::uint32_t index, std::uint32_t count, std::uint32_t seed);

/// Stratum `index` of `count` of a light, with its share of the strength. A stratum of a lamp stands for a patch of its
/// surface: near it the light of a point would grow without bound, that of a disc as large is
/// intensity / (r^2 + disc_radius^2) on its axis. What the softening takes away farther off falls with 1 / count. One
/// stratum alone is the lamp's centre, not a point of its rim.
[[nodiscard]] LightSample stratum_of(const Light& light, std::uint32_t light_index, std::uint32_t index,
                                     std::uint32_t count, std::uint32_t seed);

/// Samples that each light gets.
struct StrataCounts {
    std::vector<std::uint32_t> of_light; ///< Per Scene::lights; 1 for those without a size.
    std::uint32_t of_world = 0;
    /// Per Scene::lights: what they give to the frame's scattered light, where that is known; else empty.
    std::vector<float> shares = {};
    LeftLights left = {}; ///< Which get none.
};
[[nodiscard]] bool has_size(const Light& light);

/// Lights that can scatter in some medium, in the scene's order, the world last. Reports what is left out and why.
[[nodiscard]] std::vector<ScatteringLight> find_scattering_lights(const Scene& scene, const Media& media,
                                                                  const Config& config, const StrataCounts& counts,
                                                                  Statistics& statistics);
} // namespace tyndall::light_shafts
