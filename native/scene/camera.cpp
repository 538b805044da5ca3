// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/camera.hpp"
#include "core/errors.hpp"
#include "scene/embree.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall {
Ray Camera::ray(float x_px, float y_px) const {
    const float x = glm::mix(window_left, window_right, x_px / static_cast<float>(width_px));
    const float y = glm::mix(window_bottom, window_top, y_px / static_cast<float>(height_px));
    if (kind == CameraKind::Orthographic) {
        // A viewport's orthographic camera clips behind itself, too; a ray's range never begins below 0.
        const float behind_m = std::min(clip_near_m, 0.0f);
        return {.origin = vec3(world_from_camera * vec4(x, y, -behind_m, 1.0f)),
                .direction = glm::normalize(forward()),
                .near_m = clip_near_m - behind_m,
                .far_m = clip_far_m - behind_m};
    }
    const vec3 through(x, y, -1.0f);
    const float metres_per_depth = glm::length(through);
    return {.origin = position(),
            .direction = glm::normalize(glm::mat3(world_from_camera) * through),
            .near_m = clip_near_m * metres_per_depth,
            .far_m = clip_far_m * metres_per_depth};
}

RayDetail Camera::detail(const vec3& direction, float footprint_px) const {
    const float pixel = std::min(std::abs(window_right - window_left) / static_cast<float>(width_px),
                                 std::abs(window_top - window_bottom) / static_cast<float>(height_px));
    if (kind == CameraKind::Orthographic)
        return {.width_m = footprint_px * pixel};
    return {.spread = footprint_px * pixel * glm::dot(direction, glm::normalize(forward()))};
}

void require_usable(const Camera& camera) {
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 3; ++row) // the negation is true for a NaN, too
            require(std::abs(camera.world_from_camera[column][row]) < largest_coordinate_m,
                    "camera: its position or rotation is not finite");
    require(std::abs(glm::determinant(glm::mat3(camera.world_from_camera))) > 0.5f,
            "camera: its axes are not orthogonal (a scale of 0)");
    // A window through which the squares of a direction's components do not fit into a float.
    for (const float edge : {camera.window_left, camera.window_right, camera.window_bottom, camera.window_top})
        require(std::abs(edge) < largest_coordinate_m, "camera: its field of view is not finite");
    require(!std::isnan(camera.clip_near_m) && !std::isnan(camera.clip_far_m), "camera: its clipping is not a number");
}
} // namespace tyndall
