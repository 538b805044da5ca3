// SPDX-License-Identifier: GPL-3.0-or-later
// Whether an object can stand where a matrix puts it, and by which matrix it does.
#pragma once
#include "core/math.hpp"

namespace tyndall {
[[nodiscard]] bool is_finite(const mat4& scene_from_object);
/// Whether it leaves a volume, relative to the product of the axes' lengths: a crystal of 1e-12 m is no flat object.
[[nodiscard]] bool is_regular(const mat4& scene_from_object);
/// Gives an object that one scale of 0 has made flat a millionth of its width as thickness: a plane scaled by (1, 1, 0)
/// stands in many a scene, Cycles draws it, and Embree's instances need an inverse. Other matrices stay as they are.
[[nodiscard]] mat4 thickened(const mat4& scene_from_object);
/// Why an instance cannot be drawn; nullptr if it can.
[[nodiscard]] const char* reason_to_drop(const mat4& scene_from_object);
/// How far from the scene's origin, along each axis, rays may start that Embree can take into an object's space.
[[nodiscard]] float reach_m(const mat4& object_from_scene);
[[nodiscard]] inline bool is_within(const vec3& position, float reach_m) {
    const vec3 along = glm::abs(position);
    return along.x <= reach_m && along.y <= reach_m && along.z <= reach_m; // false for a NaN, too
}
/// In double precision on the way.
[[nodiscard]] mat4 inverse_of(const mat4& scene_from_object);
} // namespace tyndall
