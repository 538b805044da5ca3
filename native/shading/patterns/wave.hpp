// SPDX-License-Identifier: GPL-3.0-or-later
// The Wave node: bands or rings, bent by noise.
// Based on: Perlin, An Image Synthesizer, SIGGRAPH 1985 (marble).
// Differs:  20 radians per unit; the noise bends by its distance from 0.5, normalized.
#pragma once
#include "shading/patterns/fractal_noise.hpp"

namespace tyndall::patterns {
struct WaveConfig {
    enum class Kind : std::uint8_t { Bands = 0, Rings = 1 };
    enum class Direction : std::uint8_t { X = 0, Y = 1, Z = 2, Diagonal = 3 }; ///< Of rings: their axis; spherical.
    enum class Profile : std::uint8_t { Sine = 0, Saw = 1, Triangle = 2 };
    Kind kind = Kind::Bands;
    Direction direction = Direction::X;
    Profile profile = Profile::Sine;
    float scale = 5.0f, distortion = 0.0f, phase_rad = 0.0f;
    float detail = 2.0f, detail_scale = 1.0f, detail_roughness = 0.5f; ///< Of the distortion.
};
/// In [0, 1].
[[nodiscard]] float wave(const vec3& vector, const WaveConfig& config);
} // namespace tyndall::patterns
