// SPDX-License-Identifier: GPL-3.0-or-later
// Perspective and orthographic cameras as Blender defines them (sensor fit, shift, pixel aspect, clipping).
#pragma once
#include "core/math.hpp"
#include "scene/ray_detail.hpp"
#include <cstdint>
#include <limits>

namespace tyndall {
enum class CameraKind : std::uint8_t { Perspective = 0, Orthographic = 1 };

struct Ray {
    vec3 origin;
    vec3 direction; ///< Unit.
    float near_m = 0.0f, far_m = std::numeric_limits<float>::infinity();
};

/// The sync resolves sensor fit, shift and aspect into the window on the plane one metre before the camera
/// (perspective) or into metres (orthographic): raster (0, 0) is the lower left corner of the full frame.
struct Camera {
    CameraKind kind = CameraKind::Perspective;
    mat4 world_from_camera{1.0f}; ///< Rotation and translation, no scale; the camera looks along its -Z.
    float window_left = -0.5f, window_right = 0.5f, window_bottom = -0.28125f, window_top = 0.28125f;
    float clip_near_m = 0.1f, clip_far_m = 1000.0f;  ///< Along -Z, as in Cycles, not along the ray.
    std::uint32_t width_px = 1920, height_px = 1080; ///< The full frame, before any border.

    /// The ray through raster position (x right, y up, in pixels). Its range is the clipping range.
    [[nodiscard]] Ray ray(float x_px, float y_px) const;
    /// As wide as so many pixels, across a ray of ray() in this direction; its number is left as it is.
    [[nodiscard]] RayDetail detail(const vec3& direction, float footprint_px) const;
    [[nodiscard]] vec3 position() const { return vec3(world_from_camera[3]); }
    [[nodiscard]] vec3 forward() const { return -vec3(world_from_camera[2]); }
    bool operator==(const Camera&) const = default;
};

/// Throws InvalidInput for a camera whose rays would not all be finite: Embree aborts the process on one that is not.
void require_usable(const Camera& camera);
} // namespace tyndall
