// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/camera.hpp"
#include "core/errors.hpp"
#include "scene/embree.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall {

vec2 Lens::sample_m(const vec2& u) const {
    vec2 place;
    if (blades < 3) {
        const float r = std::sqrt(u.x), turn = 2.0f * pi * u.y;
        place = r * vec2(std::cos(turn), std::sin(turn));
    } else {
        // One of the triangles between the centre and two corners on the circle, and a point of it.
        const float side = std::floor(u.x * static_cast<float>(blades));
        const float outward = std::sqrt(u.x * static_cast<float>(blades) - side);
        const float half_turn = pi / static_cast<float>(blades), turn = rotation_rad + 2.0f * half_turn * side;
        const vec2 at = outward * vec2(std::cos(half_turn), (2.0f * u.y - 1.0f) * std::sin(half_turn));
        place = {std::cos(turn) * at.x - std::sin(turn) * at.y, std::sin(turn) * at.x + std::cos(turn) * at.y};
    }
    return radius_m * vec2(place.x * inverse_ratio, place.y);
}

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
    if (is_panoramic()) {
        const std::optional<vec3> towards = panorama.direction({x, y});
        if (!towards)
            return Ray::none(position(), glm::normalize(forward()));
        return {.origin = position(),
                .direction = glm::normalize(glm::mat3(world_from_camera) * *towards),
                .near_m = clip_near_m,
                .far_m = clip_far_m};
    }
    const vec3 through(x, y, -1.0f);
    const float metres_per_depth = glm::length(through);
    return {.origin = position(),
            .direction = glm::normalize(glm::mat3(world_from_camera) * through),
            .near_m = clip_near_m * metres_per_depth,
            .far_m = clip_far_m * metres_per_depth};
}

Ray Camera::ray_or_rim(float x_px, float y_px) const {
    const Ray there = ray(x_px, y_px);
    if (there.exists())
        return there;
    const vec2 low(window_left, window_bottom), high(window_right, window_top);
    const vec2 size_px(static_cast<float>(width_px), static_cast<float>(height_px));
    const vec2 at = panorama.beyond_rim(low + vec2(x_px, y_px) / size_px * (high - low));
    const vec2 place_px = (at - low) / (high - low) * size_px;
    Camera endless = *this;
    endless.panorama.rim = std::numeric_limits<float>::infinity();
    return endless.ray(place_px.x, place_px.y);
}

Ray Camera::through_lens(const Ray& sharp, const vec2& u) const {
    if (lens.is_pinhole() || !sharp.exists())
        return sharp;
    const vec2 at_m = lens.sample_m(u);
    const vec3 ahead = glm::normalize(forward());
    vec3 right(world_from_camera[0]), up(world_from_camera[1]);
    float focus_m = lens.focus_m;
    if (is_panoramic()) { // the lens stands across each ray, as in Cycles, where a mirror ball's is a mirrored one
        const bool is_ball = panorama.kind == PanoramaKind::MirrorBall;
        const vec3 axis = is_ball ? glm::normalize(right) : ahead;
        const vec3 across = axis - glm::dot(axis, sharp.direction) * sharp.direction;
        right = glm::length(across) > 1e-6f ? glm::normalize(across) : is_ball ? ahead : right;
        up = is_ball ? glm::cross(right, sharp.direction) : glm::cross(sharp.direction, right);
    } else {
        focus_m /= glm::dot(sharp.direction, ahead);
    }
    const vec3 aside = at_m.x * right + at_m.y * up;
    Ray blurred = sharp;
    blurred.origin += aside;
    blurred.direction = glm::normalize(focus_m * sharp.direction - aside);
    const float per_sharp = 1.0f / sharp_per_blurred_m(sharp, blurred);
    blurred.near_m *= per_sharp;
    blurred.far_m *= per_sharp;
    return blurred;
}

Camera Camera::of_air() const {
    Camera pinhole = *this;
    pinhole.lens = {};
    if (lens.is_pinhole() || !lens.air_u)
        return pinhole;
    const vec2 at_m = lens.sample_m(*lens.air_u), moved = at_m / lens.focus_m;
    pinhole.world_from_camera[3] = world_from_camera * vec4(at_m, 0.0f, 1.0f);
    pinhole.window_left -= moved.x, pinhole.window_right -= moved.x;
    pinhole.window_bottom -= moved.y, pinhole.window_top -= moved.y;
    return pinhole;
}

float Camera::sharp_per_blurred_m(const Ray& sharp, const Ray& blurred) const {
    if (is_panoramic())
        return glm::dot(blurred.direction, sharp.direction);
    return glm::dot(blurred.direction, forward()) / glm::dot(sharp.direction, forward());
}

std::optional<vec2> Camera::raster_position(const vec3& point) const {
    const vec3 seen = glm::transpose(mat3(world_from_camera)) * (point - position());
    const vec2 low(window_left, window_bottom), high(window_right, window_top);
    vec2 at(seen);
    if (kind == CameraKind::Perspective) {
        if (!(seen.z < 0.0f))
            return {};
        at /= -seen.z;
    } else if (is_panoramic()) {
        const std::optional<vec2> place = panorama.place(seen, low, high);
        if (!place)
            return {};
        at = *place;
    }
    return (at - low) / (high - low) * vec2(static_cast<float>(width_px), static_cast<float>(height_px));
}

float Camera::depth_m(const vec3& point) const {
    return is_panoramic() ? glm::length(point - position()) : glm::dot(point - position(), forward());
}

RayDetail Camera::detail(const vec3& direction, float footprint_px) const {
    const float pixel = std::min(std::abs(window_right - window_left) / static_cast<float>(width_px),
                                 std::abs(window_top - window_bottom) / static_cast<float>(height_px));
    if (kind == CameraKind::Orthographic)
        return {.width_m = footprint_px * pixel};
    if (is_panoramic()) {
        const vec2 turns = panorama.turns(glm::transpose(mat3(world_from_camera)) * direction);
        return {.spread = footprint_px * pixel * 0.5f * (turns.x + turns.y)};
    }
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
    require(std::isfinite(camera.lens.radius_m) && std::isfinite(camera.lens.inverse_ratio) &&
                std::isfinite(camera.lens.rotation_rad) && camera.lens.radius_m < largest_coordinate_m,
            "camera: its aperture is not finite");
    require(camera.lens.is_pinhole() || (camera.lens.focus_m > 0.0f && camera.lens.focus_m < largest_coordinate_m),
            "camera: it focuses at a distance of 0, or at none");
    // Nearer, what leaves its rim would go sideways, and rounding decides whether it goes ahead or back.
    constexpr float nearest_per_radius = 1e-4f;
    require(camera.lens.is_pinhole() || camera.lens.focus_m >= nearest_per_radius * camera.lens.radius_m *
                                                                   std::max(camera.lens.inverse_ratio, 1.0f),
            "camera: it focuses at ", camera.lens.focus_m, " m, too near for an aperture of ", camera.lens.radius_m,
            " m");
    const vec2 air_u = camera.lens.air_u.value_or(vec2(0.0f)); // the negation is true for a NaN, too
    require(air_u.x >= 0.0f && air_u.x < 1.0f && air_u.y >= 0.0f && air_u.y < 1.0f &&
                (!camera.lens.air_u || camera.kind == CameraKind::Perspective),
            "camera: air is seen through a point of [0, 1)^2 of a perspective camera's lens");
    require(camera.kind <= CameraKind::Panoramic && camera.panorama.kind <= PanoramaKind::CentralCylindrical,
            "camera: there is no such kind");
    require(!std::isnan(camera.panorama.rim) &&
                std::ranges::all_of(camera.panorama.angle_by_radius, [](float k) { return std::isfinite(k); }),
            "camera: its fisheye's field of view or polynomial is not finite");
    require(!std::isnan(camera.clip_near_m) && !std::isnan(camera.clip_far_m), "camera: its clipping is not a number");
}
} // namespace tyndall
