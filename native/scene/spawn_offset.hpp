// SPDX-License-Identifier: GPL-3.0-or-later
// Where a ray leaves an instanced triangle: the hit's position, and how far along the normal all rounding may reach.
// Based on: Binder, Waechter et al., Self-Intersection Avoidance, NVIDIA 2022: bounds of the rounding of the hit's
//           position in object space, of both transforms and of the triangle test, added up along the normal.
// Differs:  an instance of one level; the offset is doubled, because Embree's robust test (Pluecker) rounds differently
//           from the watertight one that the paper's constants were derived for.
// Bound:    42 multiply-adds; an offset of 2e-7 of the largest coordinate: 12 mm at 60 km, 0.1 um at 0.5 m.
#pragma once
#include "core/math.hpp"
#include <array>

namespace tyndall {
struct SpawnPoint {
    vec3 position;
    vec3 normal; ///< Unit.
    float offset_m;

    /// The origin for a ray in `direction`, off the surface on that side.
    [[nodiscard]] vec3 towards(const vec3& direction) const {
        return position + (glm::dot(direction, normal) < 0.0f ? -offset_m : offset_m) * normal;
    }
};
/// `corners` in object space; both transforms affine, each the other's inverse.
[[nodiscard]] SpawnPoint spawn_point(const std::array<vec3, 3>& corners, vec2 barycentrics,
                                     const mat4& scene_from_object, const mat4& object_from_scene);
} // namespace tyndall
