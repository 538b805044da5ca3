// SPDX-License-Identifier: GPL-3.0-or-later
// What a softened patch of a lamp's surface (LightSample::softening_m2) gives a point next to the lamp.
// Based on: van Oosterom and Strackee, The Solid Angle of a Plane Triangle, IEEE Trans. Biomed. Eng. 30, 1983, eq. 8.
// Differs:  a patch of an area light or of a sphere shines on a point as on one that lies farther before the lamp, and all
//           patches together as the whole lamp does from there: too little next to it, and beside an area light too much.
//           What a point gets is multiplied by the share of the solid angles in which both see the whole lamp, and its
//           directions are stretched by that share. The triangles' half angles are summed as a product of complex
//           numbers.
#pragma once
#include "scene/area_light.hpp"
#include <array>

namespace tyndall {
/// A local sample from a point; a softened patch as from a point that lies before the lamp by the root of the sum of the
/// softening and of the square of how far this one does.
struct LocalView {
    vec3 from_light;  ///< The direction of its light. Of all patches as many are aside as of the whole lamp.
    float distance_m; ///< That it has come through; of patches next to the point less than the way to them.
    Rgb irradiance;   ///< Of what faces the light; without what dims it on its way.
};
/// `point` is not the sample's position.
[[nodiscard]] LocalView view_local(const LightSample& sample, const vec3& point);
/// LocalView::distance_m alone.
[[nodiscard]] float local_distance_m(const LightSample& sample, const vec3& point);

/// A rectangle's corners, or those of an octagon of an ellipse's area, in turn around its middle, along its light_axes.
struct AreaOutline {
    std::array<vec2, 8> corners_m;
    std::size_t count; ///< 4 or 8.
};
[[nodiscard]] AreaOutline area_outline(const Light& light);
/// Half the solid angle under which it is seen from a point so far before the place `foot_m` of its plane.
[[nodiscard]] double half_solid_angle_sr(const AreaOutline& outline, const dvec2& foot_m, double height_m);

/// How wide an area light's edge fades beside that of one of the same height without slats; fitted, to 2 % of the light.
[[nodiscard]] inline double edge_width(const AreaSpread& spread) {
    return 1.0 / (1.0 + 7.0 * double{spread.cotangent});
}
/// Where the square of how far a point lies before a patch is this many of its softening, both see the lamp alike, to
/// 0.1 %; up to twice as many that is faded out.
inline constexpr double far_before_softenings = 500.0;
} // namespace tyndall
