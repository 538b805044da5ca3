// SPDX-License-Identifier: GPL-3.0-or-later
// The texture of the air: how much more or less than a homogeneous medium each point scatters.
// Based on: Kol, dissertation, TU Delft 2018, section 5.4.3.
// Differs:  the noise N is divided by its mean, so that it neither darkens nor brightens the air; the paper's blend of N,
//           about 0.5 on average, with 1 darkens. Painted values are relative to the ones that hold everywhere: a slider
//           still moves all of the picture, and the border of the painted box does not show.
#pragma once
#include "core/math.hpp"
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace tyndall {
/// Perlin noise in a periodic cube of resolution^3 texels that tiles space.
struct AirNoise {
    float scale_m = 1.0f;           ///< Size of its largest features, (0, 1e6].
    std::uint32_t octaves = 5;      ///< [1, 8].
    float persistence = 0.5f;       ///< Weight of an octave relative to the one before, [0, 1].
    std::uint32_t resolution = 256; ///< A power of two, [16, 512].
    std::uint32_t seed = 0;
};

/// Values over the unit cube, x fastest: sample i of n lies at (i + 0.5) / n. Empty: nothing is painted.
struct PaintedVolume {
    std::array<std::uint32_t, 3> size{};
    std::vector<float> values;
    [[nodiscard]] bool is_empty() const { return values.empty(); }
};

/// What a point x scatters relative to a homogeneous medium:
///     I(x) (a(x) N(x - moved_m, f(x)) / mean(N) + 1 - a(x)),
///     a = clamp(amount + painted, 0, 1), f = max(level + painted, 0), I = intensity * painted.
struct Heterogeneity {
    enum class Weighting : std::uint8_t {
        LitParts = 0, ///< Mean over what is lit of a ray, as it scatters.
        WholeRay = 1, ///< Over its length in media, as the paper has it.
    };
    AirNoise noise;
    vec3 moved_m{0.0f};     ///< How far the wind has carried the noise.
    float amount = 1.0f;    ///< [0, 1]; 0: homogeneous.
    float level = 0.0f;     ///< Mip level of the noise, [0, 8]; higher ones are smoother.
    float intensity = 1.0f; ///< [0, 1000].
    Weighting weighting = Weighting::LitParts;
    std::uint32_t step_count = 64;   ///< Per ray, [1, 4096].
    std::uint32_t upsampling = 1;    ///< Pixels per side that share a ray's texture, guided by depth: 1, 2, 4, 8 or 16.
    mat4 unit_from_scene{1.0f};      ///< Of the painted box; outside of it nothing is painted.
    PaintedVolume painted_amount;    ///< Added, [-1, 1].
    PaintedVolume painted_level;     ///< Added, [-8, 8].
    PaintedVolume painted_intensity; ///< Multiplied, [0, 1000].
};
} // namespace tyndall
