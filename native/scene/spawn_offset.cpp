// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/spawn_offset.hpp"
#include <algorithm>

namespace tyndall {
static mat3 absolute(const mat4& matrix) {
    return mat3(glm::abs(vec3(matrix[0])), glm::abs(vec3(matrix[1])), glm::abs(vec3(matrix[2])));
}

SpawnPoint spawn_point(const std::array<vec3, 3>& corners, vec2 barycentrics, const mat4& scene_from_object,
                       const mat4& object_from_scene) {
    constexpr float half_ulp = 0x1p-24f;
    const vec3 first_edge = corners[1] - corners[0], second_edge = corners[2] - corners[0];
    // The corner last: the edges' sum is small, so that rounding happens once at the size of the corner.
    const vec3 in_object = corners[0] + (barycentrics.x * first_edge + barycentrics.y * second_edge);
    const vec3 position = vec3(scene_from_object[3]) + mat3(scene_from_object) * in_object;

    const vec3 twice_extents =
        glm::abs(first_edge) + glm::abs(second_edge) + glm::abs(glm::abs(first_edge) - glm::abs(second_edge));
    const float twice_extent = std::max({twice_extents.x, twice_extents.y, twice_extents.z});
    // Of interpolation and triangle test; of the way into the scene; of the ray's origin on its way back.
    vec3 object_error = half_ulp * glm::abs(corners[0]) + 3.0f * half_ulp * twice_extent;
    const vec3 scene_error = 3.0f * half_ulp * (absolute(scene_from_object) * glm::abs(in_object)) +
                             2.0f * half_ulp * glm::abs(vec3(scene_from_object[3]));
    object_error +=
        2.0f * half_ulp * (absolute(object_from_scene) * glm::abs(position) + glm::abs(vec3(object_from_scene[3])));

    // Scaled first: the product of a micrometre's edges underflows.
    const vec3 object_normal = glm::cross(first_edge / twice_extent, second_edge / twice_extent);
    const vec3 scene_normal = glm::transpose(mat3(object_from_scene)) * object_normal;
    const float scale = 1.0f / glm::length(scene_normal);
    const vec3 normal = scale * scene_normal;
    const float offset_m =
        scale * glm::dot(object_error, glm::abs(object_normal)) + glm::dot(scene_error, glm::abs(normal));
    return {.position = position, .normal = normal, .offset_m = 2.0f * offset_m};
}
} // namespace tyndall
