// SPDX-License-Identifier: GPL-3.0-or-later
// Blender's hair shaders made into lobes of a fibre.
// Based on: Chiang et al., A Practical and Controllable Hair and Fur Model for Production Path Tracing, EG 2016: what
//           passes a fibre, is mirrored by it, and in it, and the fits of roughness and colour (eq. 6 to 9); d'Eon et al.,
//           An Energy-Conserving Hair Reflectance Model, EGSR 2011: absorption of melanin; blender v4.5.0,
//           intern/cycles/kernel/svm/closure.h: how much melanin a share is, and what a hair's number makes differ.
// Differs:  where on its fibre's width a point lies is told by its normal, of bands, too.
#pragma once
#include "shading/lobes/lobe_models.hpp"

namespace tyndall {
/// By model, how many inputs its kind has; 0: it is no hair.
[[nodiscard]] std::size_t hair_input_count(LobeModel model);
/// As add_lobes, for those.
void add_hair_lobes(const LobeSource& source, const LobeInputs& inputs, const ShadingPoint& point, const vec3& outgoing,
                    SurfaceClosures& closures, Lobes* lobes);

namespace hair {
/// Absorption per fibre's radius of a colour that many hairs have together, by their roughness around.
[[nodiscard]] Rgb absorption_of_colour(const Rgb& colour, float radial_roughness);
/// Of melanin, [0, 1] of which is as it looks; redness: how much of it is pheomelanin.
[[nodiscard]] Rgb absorption_of_melanin(float melanin, float redness);
/// Variance along and scale around of a fibre's surface that is as rough.
[[nodiscard]] float variance_along(float roughness);
[[nodiscard]] float scale_around(float roughness);

/// What becomes of light that meets a fibre: shares that add up to 1 if nothing is absorbed.
struct Shares {
    Rgb mirrored, through, mirrored_inside, further;
    float refracted; ///< Angle of the way through, across the fibre.
};
/// The viewer's theta; where on the fibre's width it looks, as an angle, and index of refraction.
[[nodiscard]] Shares shares(float sine_theta, float cosine_theta, float gamma, const Rgb& absorption, float ior);
} // namespace hair
} // namespace tyndall
