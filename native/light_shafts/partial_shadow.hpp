// SPDX-License-Identifier: GPL-3.0-or-later
// Shadows of triangles that let part of the light pass: constant transparency, or a texture's alpha along the cut.
#pragma once
#include "light_shafts/strip_kernel.hpp"
#include "light_shafts/visibility.hpp"
#include <vector>

namespace tyndall::light_shafts {
/// A part of a view ray behind one partly transparent triangle.
struct PartialShadow {
    float near_m, far_m;
    Rgb transmittance;
};

/// Appends the shadows of one cut triangle, in any order, without parts through which all light passes. A texture is
/// evaluated between every two texel borders that the cut crosses: exact for unfiltered textures, and the mean over each
/// texel for filtered ones. A cut across more than 1,024 texels takes 1,024 even steps, and one
/// through a surface that reads more of its points than images 32.
void append_partial_shadows(const Scene& scene, const StripScene& strip, const PartialCut& cut, const StripRay& ray,
                            std::vector<PartialShadow>& shadows);

/// Appends what is left of [near_m, far_m] of a ray: outside the opaque shadows whole, inside partial ones dimmed by
/// the product over all that overlap. `partial` comes back sorted.
void append_lit_intervals(const ShadowUnion& opaque, std::vector<PartialShadow>& partial,
                          std::vector<LitInterval>& lit);
} // namespace tyndall::light_shafts
