// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/pixel_footprint.hpp"

namespace tyndall::render {
PixelFootprint pixel_footprint(const Camera& camera, const vec3& direction) {
    const float width = (camera.window_right - camera.window_left) / static_cast<float>(camera.width_px),
                height = (camera.window_top - camera.window_bottom) / static_cast<float>(camera.height_px);
    if (camera.kind == CameraKind::Orthographic)
        return {.width_m = std::abs(width), .spread = 0.0f};
    const vec3 in_camera = glm::transpose(mat3(camera.world_from_camera)) * direction;
    if (camera.is_panoramic()) {
        const vec2 turns = camera.panorama.turns(in_camera);
        return {.width_m = 0.0f, .spread = 0.5f * (std::abs(width) * turns.x + std::abs(height) * turns.y)};
    }
    const vec3 through = in_camera / -in_camera.z;
    const auto turn = [&](const vec3& step) {
        return glm::length(glm::normalize(through + step) - glm::normalize(through));
    };
    return {.width_m = 0.0f, .spread = 0.5f * (turn({width, 0.0f, 0.0f}) + turn({0.0f, height, 0.0f}))};
}
} // namespace tyndall::render
