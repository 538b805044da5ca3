// SPDX-License-Identifier: GPL-3.0-or-later
// The Noise node: octaves of gradient noise over a place that other noises displace.
// Based on: fractal_noise.hpp; domain distortion as in Perlin, An Image Synthesizer, SIGGRAPH 1985.
// Differs:  each coordinate is displaced by the undisplaced place's noise, somewhere else in the lattice; green and
//           blue are the same noise, again elsewhere. Where "elsewhere" lies is Cycles' choice: a hash of small
//           numbers.
// Bound:    a colour costs three numbers; distortion one noise per dimension.
#pragma once
#include "shading/patterns/fractal_noise.hpp"

namespace tyndall::patterns {
struct NoiseConfig {
    int dimensions = 3; ///< 1 to 4
    Fractal fractal = Fractal::Fbm;
    bool is_normalized = true; ///< Of Fbm alone.
    float w = 0.0f, scale = 5.0f, distortion = 0.0f;
    Octaves octaves = {}; ///< Detail and factor (the node's roughness) are clamped to what the node allows.
};
[[nodiscard]] float noise(const vec3& vector, const NoiseConfig& config);
[[nodiscard]] Rgb noise_colour(const vec3& vector, const NoiseConfig& config);
} // namespace tyndall::patterns
