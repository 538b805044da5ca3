// SPDX-License-Identifier: GPL-3.0-or-later
// What facets of a lobe send back that are wider along one direction than across it, or not of GGX: of those that are, and
// as wide along as across, see ggx.hpp.
// Based on: Burley, Physically Based Shading at Disney, SIGGRAPH 2012 course notes, appendix B.2 (eq. 13: two widths);
//           Heitz, Understanding the Masking-Shadowing Function, JCGT 3(2), 2014 (section 5.4); Heitz, Sampling the GGX
//           Distribution of Visible Normals, JCGT 7(4), 2018; beckmann.hpp; ashikhmin_shirley.hpp.
// Bound:    GGX of two widths: 1.4 times the time of ggx.hpp a direction, 1.1 times to draw one.
#pragma once
#include "core/math.hpp"
#include "shading/lobes/lobe.hpp"

namespace tyndall::framed_facets {
/// Radiance per irradiance that white facets send back, 1/sr. Unit vectors; cosines of both to the normal are above 0.
[[nodiscard]] float per_irradiance(const Lobe& lobe, const vec3& normal, const vec3& outgoing, const vec3& incoming);
/// With which sample() draws a direction; 0: no facet that is seen mirrors light there.
[[nodiscard]] float pdf_per_sr(const Lobe& lobe, const vec3& normal, const vec3& outgoing, const vec3& incoming);
/// The normal of the facet that mirrors a direction, which may lie below the horizon.
[[nodiscard]] vec3 sample_normal(const Lobe& lobe, const vec3& normal, const vec3& outgoing, vec2 u);
/// No direction is denser, roughly.
[[nodiscard]] float most_pdf_per_sr(const Lobe& lobe, const vec3& normal, const vec3& outgoing);
} // namespace tyndall::framed_facets
