// SPDX-License-Identifier: GPL-3.0-or-later
// What a camera's pixel covers of the scene.
// Based on: Igehy, Tracing Ray Differentials, SIGGRAPH 1999, as blender/cycles v4.5.0 shortens it to one number per ray:
//           src/kernel/camera/camera.h and src/kernel/util/differential.h.
#pragma once
#include "scene/camera.hpp"

namespace tyndall::render {
struct PixelFootprint {
    float width_m = 0.0f; ///< Where its ray begins.
    float spread = 0.0f;  ///< What each metre of the way adds.
};
/// Of a ray of Camera::ray() in this direction: the mean of the ways to the pixels on the right and above.
[[nodiscard]] PixelFootprint pixel_footprint(const Camera& camera, const vec3& direction);
} // namespace tyndall::render
