// SPDX-License-Identifier: GPL-3.0-or-later
// What a directional light with a picture before it scatters along view rays: from running integrals of the picture along
// the lines that the rays of the view share, or, for rays that those do not reach, step by step.
// Bound:    texture_rows.hpp. Steps: one per half texel that the ray crosses, between 64 and 256 per ray; where the picture
//           is finer they read its means over squares as wide as a step. The error of both is measured in
//           textured_lights_test.cpp.
#pragma once
#include "light_shafts/texture_rows.hpp"

namespace tyndall::light_shafts {
/// As Visibility::add_scattered, of a light with a texture. No rows: step by step.
void add_textured(const Visibility& visibility, const Light& light, const TextureRows* rows,
                  std::span<const ViewRay> rays, const PieceRows& pieces, std::span<Rgb> radiance,
                  std::span<float> lit_length_m);
/// One ray, with so many steps for all its lit parts together.
[[nodiscard]] Rgb scattered_in_steps(const Light& light, const ViewRay& ray, std::span<const ScatterPiece> pieces,
                                     std::span<const LitInterval> lit, float step_count);
} // namespace tyndall::light_shafts
