// SPDX-License-Identifier: GPL-3.0-or-later
// How far a directional light travels in each medium before it reaches the points of a view ray: terms that are linear
// in the distance along the ray, between the cuts of the media's boundaries with the plane of ray and light.
#pragma once
#include "light_shafts/light_shafts.hpp"
#include "scene/media.hpp"
#include <vector>

namespace tyndall::light_shafts {
/// On (near_m, far_m) of the ray, the light has way_at_zero_m + way_per_m * t behind it in the medium; several terms of
/// a medium add up, and some are negative (a boundary that is entered on the way from the point to the light).
struct LightSideTerm {
    double near_m, far_m;
    double way_at_zero_m, way_per_m;
    std::uint16_t medium;
};

/// Appends the terms of one boundary for points of [ray.near_m, ray.far_m].
void append_light_side_terms(const Media& media, const MediumBoundary& boundary, const ViewRay& ray,
                             const vec3& towards_light, std::vector<LightSideTerm>& terms);
} // namespace tyndall::light_shafts
