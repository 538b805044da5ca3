// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/plane_cut.hpp"
#include <algorithm>

namespace tyndall {
static PlaneCoordinates<double> coordinates_from(const dvec3& origin, const dvec3& along_ray, const dvec3& to_light) {
    const dvec3 normal = glm::cross(along_ray, to_light);
    const auto through_origin = [&](const dvec3& direction) {
        return Covector<double>{direction, -glm::dot(direction, origin)};
    };
    return {through_origin(normal), through_origin(along_ray), through_origin(to_light)};
}

DirectionalPlane plane_towards(const vec3& ray_origin, const vec3& ray_direction, const vec3& towards_light) {
    const dvec3 along_ray = glm::normalize(dvec3(ray_direction)), light = glm::normalize(dvec3(towards_light));
    const double cosine = glm::dot(along_ray, light);
    const dvec3 across = light - cosine * along_ray;
    const double sine = glm::length(across);
    constexpr double least_sine = 1e-6;
    if (sine >= least_sine)
        return {coordinates_from(dvec3(ray_origin), along_ray, across / sine), sine, cosine};
    const dvec3 any_across(orthonormal_basis(ray_direction).first);
    const dvec3 to_light = glm::normalize(any_across - glm::dot(any_across, along_ray) * along_ray);
    return {coordinates_from(dvec3(ray_origin), along_ray, to_light), least_sine, std::copysign(1.0, cosine)};
}

LocalPlane plane_through(const vec3& ray_origin, const vec3& ray_direction, const vec3& light_position) {
    const dvec3 along_ray = glm::normalize(dvec3(ray_direction));
    const dvec3 to_light = dvec3(light_position) - dvec3(ray_origin);
    const double light_x = glm::dot(along_ray, to_light);
    const dvec3 across = to_light - light_x * along_ray;
    const double light_y = glm::length(across);
    // Positions are floats: nearer to the line than this, the side of the light is noise.
    const double least_y = std::max(1e-6 * glm::length(to_light), 1e-30);
    if (light_y >= least_y)
        return {coordinates_from(dvec3(ray_origin), along_ray, across / light_y), light_x, light_y};
    const dvec3 any_across(orthonormal_basis(ray_direction).first);
    const dvec3 unit = glm::normalize(any_across - glm::dot(any_across, along_ray) * along_ray);
    return {coordinates_from(dvec3(ray_origin), along_ray, unit), light_x, least_y};
}
} // namespace tyndall
