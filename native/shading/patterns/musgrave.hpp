// SPDX-License-Identifier: GPL-3.0-or-later
// The Musgrave node of Blender up to 4.0: octaves whose strengths are powers of the lacunarity.
// Based on: Musgrave, in Ebert et al., Texturing and Modeling, 3rd ed. 2003, chapter 16.
// Differs:  see fractal_noise.hpp; nothing is brought to [0, 1].
#pragma once
#include "shading/patterns/fractal_noise.hpp"

namespace tyndall::patterns {
struct MusgraveConfig {
    int dimensions = 3; ///< 1 to 4
    Fractal fractal = Fractal::Fbm;
    float w = 0.0f, scale = 5.0f, detail = 2.0f, dimension = 2.0f, lacunarity = 2.0f, offset = 0.0f, gain = 1.0f;
};
[[nodiscard]] float musgrave(const vec3& vector, const MusgraveConfig& config);
} // namespace tyndall::patterns
