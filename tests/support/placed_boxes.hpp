// SPDX-License-Identifier: GPL-3.0-or-later
// Scattered boxes in the ball that settings of slope rows look at, as a shape of cells or as meshes.
#pragma once
#include "support/box_shape.hpp"
#include "support/shaft_settings.hpp"

namespace tyndall::support {
/// `counted` cells: beyond what is drawn by its faces.
inline std::shared_ptr<const BoxShape> boxes_of(std::uint64_t counted = 0) {
    return std::make_shared<const BoxShape>(scattered_cells(80, 8, 7), 0.4f, counted);
}
/// Two of them; no face lies along a light line.
inline BoxScene placed_boxes(const Setting& setting = {}) {
    const mat4 there = glm::scale(translation(setting.centre), vec3(setting.scale_m));
    return {.places = {there * glm::rotate(translation({-1.6f, -1.6f, -1.0f}), 0.3f, glm::normalize(vec3(1, 1, 2))),
                       there * glm::rotate(glm::scale(translation({2.5f, 1.0f, 0.5f}), vec3(-0.7f, 0.8f, 0.6f)), 0.2f,
                                           glm::normalize(vec3(2, 1, 1)))}};
}
} // namespace tyndall::support
