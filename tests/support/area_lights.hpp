// SPDX-License-Identifier: GPL-3.0-or-later
// Area lights that stand in no plane that modellers favour, and what a rectangle's edges say that it gives.
#pragma once
#include "core/sampling.hpp"
#include "scene/light.hpp"
#include "scene/light_axes.hpp"
#include <array>
#include <numbers>
#include <vector>

namespace tyndall::support {
inline Light area_light(const vec2& half_size_m) {
    const vec3 axis = glm::normalize(vec3(0.3f, -0.5f, -0.8f));
    const auto [tangent, bitangent] = orthonormal_basis(-axis);
    return {.name = "Area",
            .kind = LightKind::Area,
            .strength = Rgb(3.0f, 2.0f, 1.0f),
            .position = {1, 2, 3},
            .spot_axis = axis,
            .spot_half_angle_rad = 0.5f * std::numbers::pi_v<float>,
            .half_size_m = half_size_m,
            .light_from_world_directions = glm::transpose(mat3(tangent, bitangent, -axis))};
}
/// The point so far before the place `foot` of the light's plane.
inline vec3 before(const Light& light, const vec2& foot, float height_m) {
    const mat3 axes = light_axes(light);
    return light.position + foot.x * axes[0] + foot.y * axes[1] + height_m * light.spot_axis;
}
/// Irradiance of a rectangle of one radiance, seen from its front, by its edges above the horizon.
/// Based on: Lambert, Photometria, 1760; Baum, Rushmeier and Winget, Improving Radiosity Solutions, SIGGRAPH 1989.
inline double lambert(const Light& light, const vec3& point, const vec3& normal) {
    const mat3 axes = light_axes(light);
    std::vector<dvec3> corners;
    for (const auto& [x, y] : {std::pair{-1.0, -1.0}, {1.0, -1.0}, {1.0, 1.0}, {-1.0, 1.0}})
        corners.push_back(dvec3(light.position) + x * light.half_size_m.x * dvec3(axes[0]) +
                          y * light.half_size_m.y * dvec3(axes[1]) - dvec3(point));
    const dvec3 n(normal);
    std::vector<dvec3> above;
    for (std::size_t index = 0; index < corners.size(); ++index) {
        const dvec3 &a = corners[index], &b = corners[(index + 1) % corners.size()];
        const double of_a = glm::dot(n, a), of_b = glm::dot(n, b);
        if (of_a >= 0.0)
            above.push_back(a);
        if ((of_a < 0.0) != (of_b < 0.0))
            above.push_back(a + of_a / (of_a - of_b) * (b - a));
    }
    double sum = 0.0;
    for (std::size_t index = 0; index < above.size(); ++index) {
        const dvec3 a = glm::normalize(above[index]), b = glm::normalize(above[(index + 1) % above.size()]);
        const dvec3 across = glm::cross(a, b);
        if (const double sine = glm::length(across); sine > 0.0)
            sum += std::atan2(sine, glm::dot(a, b)) * glm::dot(n, across) / sine;
    }
    const double radiance = double{light.strength.x} / (4.0 * light.half_size_m.x * light.half_size_m.y);
    return 0.5 * radiance * std::abs(sum);
}
} // namespace tyndall::support
