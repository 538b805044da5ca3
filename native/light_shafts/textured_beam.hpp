// SPDX-License-Identifier: GPL-3.0-or-later
// What a directional light with a picture before it scatters along view rays.
// Bound:    texture_steps.hpp, with a step per texel that the ray crosses while that makes no more than most_steps; where
//           the picture is finer, steps are longer and read means over squares as wide as a step. Against steps 16 times
//           finer: see textured_beam_test.cpp.
#pragma once
#include "light_shafts/visibility.hpp"

namespace tyndall::light_shafts {
/// Per ray and light sample.
constexpr float most_texture_steps = 128.0f;

/// As Visibility::add_scattered, of a light with a texture.
void add_textured(const Visibility& visibility, const Light& light, std::span<const ViewRay> rays,
                  const PieceRows& pieces, std::span<Rgb> radiance, std::span<float> lit_length_m,
                  float most_steps = most_texture_steps);
} // namespace tyndall::light_shafts
