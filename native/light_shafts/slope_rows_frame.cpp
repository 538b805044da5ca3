// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/slope_rows_frame.hpp"
#include <tuple>

namespace tyndall::light_shafts::slope_rows {
static void set_axis(Frame& frame, const vec3& axis) {
    frame.axis = axis;
    std::tie(frame.u, frame.v) = orthonormal_basis(axis);
}

static std::optional<Frame> orthographic_frame(const View& view, const LightSample& light) {
    Frame frame;
    frame.is_orthographic = true;
    if (!light.is_directional) {
        frame.origin = light.position;
        set_axis(frame, -view.direction);
        frame.is_angular = true;
        frame.angle_scale = 1.0f;
        frame.x = {0, 1, 0};
        frame.y = {1, 0, 0};
        return frame;
    }
    const vec3 across = glm::cross(light.towards_light, view.direction);
    const float sine = glm::length(across);
    if (!(sine > 1e-4f)) // the sun stands behind the camera or in front of it: every ray is a light line
        return std::nullopt;
    frame.origin = view.position;
    frame.axis = light.towards_light;
    frame.v = across / sine;
    frame.u = glm::cross(frame.v, frame.axis); // along the view: r rises along every ray
    frame.is_parallel = true;
    const float slope = glm::dot(view.direction, frame.axis) / glm::dot(view.direction, frame.u);
    frame.x = {0, 0, 1};
    frame.y = {0, 1, -slope};
    frame.w = {1, 0, 0};
    return frame;
}

std::optional<Frame> make_frame(const View& view, const LightSample& light) {
    if (view.is_orthographic)
        return orthographic_frame(view, light);
    Frame frame;
    frame.origin = view.position;
    if (light.is_directional) {
        set_axis(frame, light.towards_light);
        return frame;
    }
    const dvec3 to_light = dvec3(light.position) - dvec3(view.position);
    const double distance_m = glm::length(to_light);
    if (!(distance_m > 1e-6 * glm::length(dvec3(view.position)) && distance_m > 1e-30))
        return std::nullopt;
    set_axis(frame, vec3(to_light / distance_m));
    frame.is_angular = true;
    frame.angle_scale = static_cast<float>(1.0 / distance_m);
    frame.x = {1, -frame.angle_scale, 0};
    return frame;
}

FramedRay Frame::place(const ViewRay& ray) const {
    const vec3 direction(glm::dot(ray.direction, u), glm::dot(ray.direction, v), glm::dot(ray.direction, axis));
    FramedRay placed{};
    placed.near_m = ray.near_m;
    placed.far_m = ray.far_m;
    placed.axial_per_m = direction.z;
    if (!is_orthographic) { // the origin is the frame's: differences of rays of one camera are rounding
        placed.slice_coordinate = std::atan2(direction.y, direction.x);
        placed.radial_per_m = std::hypot(direction.x, direction.y);
        placed.slope = placed.axial_per_m / placed.radial_per_m;
        return placed;
    }
    const vec3 start = ray.origin - origin;
    placed.axial = glm::dot(start, axis);
    const vec2 across(glm::dot(start, u), glm::dot(start, v));
    if (is_parallel) {
        placed.slice_coordinate = across.y;
        placed.radial = across.x;
        placed.radial_per_m = direction.x;
        placed.slope = y.at(placed.axial, placed.radial);
    } else {
        placed.slice_coordinate = std::atan2(across.y, across.x);
        placed.radial = std::hypot(across.x, across.y);
        placed.radial_per_m = 0.0f;
        placed.slope = 1.0f / placed.radial;
    }
    return placed;
}

float Frame::line_at(const FramedRay& ray, float distance_m) const {
    const float a = ray.axial + distance_m * ray.axial_per_m, r = ray.radial + distance_m * ray.radial_per_m;
    return is_angular ? std::atan2(angle_scale * r, x.at(a, r)) : r;
}

float Frame::x_of_line(float line) const {
    if (is_angular)
        return angle_scale * std::cos(line) / std::sin(line);
    return is_parallel ? line : 1.0f / line;
}
} // namespace tyndall::light_shafts::slope_rows
