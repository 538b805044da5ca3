// SPDX-License-Identifier: GPL-3.0-or-later
// What a textured directional light scatters along a view ray, as a weighted sum of its texture: nodes that do not depend
// on the texture's values. (The light map fit, which needs a matrix, integrates along lines of texels instead.)
// Based on: Kol, dissertation, TU Delft 2018, eq. 5.1 per step.
// Differs:  a step's weight integrates the exponential of its piece exactly, and its node lies where the exponential has
//           its mean: a texture that is linear along the step has no error at all, whatever the step's optical depth.
// Bound:    per lit part of a piece 6 exponentials and 9 expm1; per step 3 products in double. Where texels change within a
//           step the error is that of the midpoint rule, see texture_steps_test.cpp.
#pragma once
#include "light_shafts/visibility.hpp"
#include "scene/planar_placement.hpp"

namespace tyndall::light_shafts {
/// A quadrature node of a lit part of a view ray before a textured directional light.
struct TextureStep {
    vec2 uv;
    Rgb weight; ///< Radiance that the step scatters towards the camera under a white texel, W/(m^2 sr).
};
/// Appends nodes such that the sum of weight * texture(uv) is the radiance that the lit parts of the ray scatter. Steps are
/// of equal length within a lit part of a piece, and no longer than step_m > 0. Safe from any thread.
void append_texture_steps(const ViewRay& ray, std::span<const ScatterPiece> pieces, std::span<const LitInterval> lit,
                          const PlanarPlacement& placement, float step_m, std::vector<TextureStep>& steps);
/// The part [0, 1] of a step at which exp(-depth * part) has its mean over the step; of either sign, 1/2 at 0.
[[nodiscard]] float mean_place(float depth);
} // namespace tyndall::light_shafts
