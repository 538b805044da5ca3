// SPDX-License-Identifier: GPL-3.0-or-later
// Perspective, orthographic and panoramic cameras as Blender defines them (sensor fit, shift, pixel aspect, clipping), and
// their lens.
#pragma once
#include "core/math.hpp"
#include "scene/panorama.hpp"
#include "scene/ray_detail.hpp"
#include <cstdint>
#include <limits>
#include <optional>

namespace tyndall {
enum class CameraKind : std::uint8_t { Perspective = 0, Orthographic = 1, Panoramic = 2 };

struct Ray {
    vec3 origin;
    vec3 direction; ///< Unit.
    float near_m = 0.0f, far_m = std::numeric_limits<float>::infinity();
    std::uint32_t passed_count = 0; ///< Transparent surfaces that all the way up to now led through.

    /// What a camera has where it sees nothing, as beside a fisheye's circle: its range is empty, so that it hits nothing.
    [[nodiscard]] static Ray none(const vec3& origin, const vec3& direction) {
        return {.origin = origin, .direction = direction, .far_m = -std::numeric_limits<float>::infinity()};
    }
    /// False of none(): nobody should ask what it meets, nor what lies behind.
    [[nodiscard]] bool exists() const { return far_m > -std::numeric_limits<float>::infinity(); }
};

/// What blurs that which is not in focus.
struct Lens {
    float radius_m = 0.0f;      ///< Of the circle around the aperture; 0: a pinhole, all is sharp.
    float focus_m = 1.0f;       ///< Along -Z; panoramic: along the ray.
    std::uint32_t blades = 0;   ///< Sides of the aperture; fewer than 3: a disc.
    float rotation_rad = 0.0f;  ///< Of the blades.
    float inverse_ratio = 1.0f; ///< Width of the aperture by its height.
    /// As of sample_m(): where light shafts are seen through, whose rows need rays that leave from one point; of a
    /// perspective camera. Nothing: the lens's middle.
    std::optional<vec2> air_u{};
    bool operator==(const Lens&) const = default;

    [[nodiscard]] bool is_pinhole() const { return !(radius_m > 0.0f); }
    /// Place on the aperture of a point of [0, 1)^2, equal areas for equal areas.
    [[nodiscard]] vec2 sample_m(const vec2& u) const;
};

/// The sync resolves sensor fit, shift and aspect into the window on the plane one metre before the camera
/// (perspective), into metres (orthographic), or into the panorama's units (panoramic): raster (0, 0) is the lower left
/// corner of the full frame.
struct Camera {
    CameraKind kind = CameraKind::Perspective;
    mat4 world_from_camera{1.0f}; ///< Rotation and translation, no scale; the camera looks along its -Z.
    float window_left = -0.5f, window_right = 0.5f, window_bottom = -0.28125f, window_top = 0.28125f;
    float clip_near_m = 0.1f, clip_far_m = 1000.0f;  ///< Along -Z, as in Cycles; panoramic: along the ray.
    std::uint32_t width_px = 1920, height_px = 1080; ///< The full frame, before any border.
    Lens lens{};
    Panorama panorama{}; ///< Of a panoramic camera.

    /// The ray through raster position (x right, y up, in pixels). Its range is the clipping range; of a panorama it may be
    /// none.
    [[nodiscard]] Ray ray(float x_px, float y_px) const;
    /// The same; where that has none, the one that a panorama would have just beyond its rim.
    [[nodiscard]] Ray ray_or_rim(float x_px, float y_px) const;
    /// A ray of ray() from elsewhere on the lens, to the same point in focus; `u` as of Lens::sample_m().
    [[nodiscard]] Ray through_lens(const Ray& sharp, const vec2& u) const;
    /// What light shafts are seen by: a pinhole at a place on the lens, that has the same picture of what is in focus.
    [[nodiscard]] Camera of_air() const;
    /// Distances along `sharp` by those of equally deep points along a ray of through_lens(); or
    /// along one of of_air() for the same place in the picture.
    [[nodiscard]] float sharp_per_blurred_m(const Ray& sharp, const Ray& blurred) const;
    /// Where ray() shows a point, x right, y up, in pixels of the full frame; nothing for one behind the camera, or that a
    /// panorama has no place for. It may lie beyond a panorama's rim, where it has no ray.
    [[nodiscard]] std::optional<vec2> raster_position(const vec3& point) const;
    /// As Blender's Depth shows it: along -Z; panoramic: from the camera.
    [[nodiscard]] float depth_m(const vec3& point) const;
    /// As wide as so many pixels, across a ray of ray() in this direction; its number is left as it is.
    [[nodiscard]] RayDetail detail(const vec3& direction, float footprint_px) const;
    [[nodiscard]] bool is_panoramic() const { return kind == CameraKind::Panoramic; }
    [[nodiscard]] vec3 position() const { return vec3(world_from_camera[3]); }
    [[nodiscard]] vec3 forward() const { return -vec3(world_from_camera[2]); }
    bool operator==(const Camera&) const = default;
};

/// Throws InvalidInput for a camera whose rays would not all be finite: Embree aborts the process on one that is not.
void require_usable(const Camera& camera);
} // namespace tyndall
