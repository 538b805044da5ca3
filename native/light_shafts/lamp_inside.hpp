// SPDX-License-Identifier: GPL-3.0-or-later
// The air within a lamp that is a sphere: its surface is as bright there from all around.
// Based on: Cycles, whose spherical point lights shine inwards as they do outwards, and spot lights whatever their cone.
// Differs:  a phase function integrates to 1, so that the air scatters the surface's radiance whatever its lobes: a closed
//           form along the ray. The strata of local_scatter.hpp are the light outside.
// Bound:    a chord per ray and turn, shared with no other pixel: it ends at the sphere. Left out: what stands in the lamp,
//           density grids and pictures.
#pragma once
#include "light_shafts/light_shafts.hpp"

namespace tyndall::light_shafts {
class LampInside {
public:
    [[nodiscard]] static bool shines_in(const Light& light) {
        return (light.kind == LightKind::Point || light.kind == LightKind::Spot) && light.body == LightBody::Sphere &&
               light.radius_m > 0.0f && !light.texture;
    }
    /// For a point within such a light: a place on its surface by two numbers in [0, 1), weighed by its density.
    static void aim_within(const Light& light, const vec3& point, vec2 u, LightSample& sample);
    LampInside(const Light& light, bool is_dimmed);
    /// Scattered to the ray's origin by the homogeneous media of its segments, W/(m^2 sr).
    [[nodiscard]] Rgb along(const Media& media, const ViewRay& ray, std::span<const MediumSegment> segments) const;

private:
    vec3 centre_;
    float radius_m_;
    Rgb radiance_;   ///< Of its surface.
    bool is_dimmed_; ///< By the air between the surface and a point.
};
} // namespace tyndall::light_shafts
