// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/strand_surface.hpp"
#include <algorithm>

namespace tyndall {
namespace {
struct StrandSurface {
    vec3 in_object, position; ///< In the scene's space.
    float radius_m;           ///< There.
};
} // namespace

/// Where light falls on a strand.
static StrandSurface surface_of(const Strands& strands, const Hit& hit, const mat4& scene_from_object) {
    const StrandPoint at = strands.on_spline(static_cast<std::uint32_t>(hit.cell), hit.barycentrics.x);
    vec3 normal = glm::transpose(mat3(scene_from_object)) * hit.geometric_normal;
    if (const float squared = glm::dot(at.tangent, at.tangent); squared > 0.0f) // that of a cone is tilted
        normal -= glm::dot(normal, at.tangent) / squared * at.tangent;
    vec3 way = glm::normalize(normal);
    if (strands.form() == StrandForm::Ribbon) {
        // On the band, as in Cycles: Embree's bands let rays pass that begin within twice their radius.
        const float sine = std::clamp(hit.barycentrics.y, -1.0f, 1.0f);
        way = sine * (sine * way + std::sqrt(1.0f - sine * sine) * glm::cross(glm::normalize(at.tangent), way));
    }
    const vec3 in_object = at.centre + at.radius_m * way;
    return {.in_object = in_object,
            .position = vec3(scene_from_object * vec4(in_object, 1.0f)),
            .radius_m = at.radius_m * glm::length(mat3(scene_from_object) * glm::normalize(normal))};
}

/// Of a sphere, in the scene's space.
static vec3 middle_of(const Strands& spheres, const Hit& hit, const mat4& scene_from_object) {
    return vec3(scene_from_object * vec4(spheres.on_spline(static_cast<std::uint32_t>(hit.cell), 0.0f).centre, 1.0f));
}

ShadingPoint strand_shading_point(const Strands& strands, const mat4& scene_from_object, const Ray& ray,
                                  const Hit& hit) {
    ShadingPoint point{.position = surface_of(strands, hit, scene_from_object).position,
                       .geometric_normal = hit.geometric_normal,
                       .shading_normal = hit.geometric_normal,
                       .triangle = hit.triangle,
                       .barycentrics = hit.barycentrics};
    if (strands.form() != StrandForm::Spheres)
        return point;
    point.geometric_normal = glm::normalize(point.position - middle_of(strands, hit, scene_from_object));
    point.is_backface = glm::dot(point.geometric_normal, ray.direction) > 0.0f;
    point.shading_normal = point.is_backface ? -point.geometric_normal : point.geometric_normal;
    return point;
}

SpawnPoint strand_spawn_point(const Strands& strands, const mat4& scene_from_object, const Hit& hit) {
    const StrandSurface surface = surface_of(strands, hit, scene_from_object);
    const vec3 reach = glm::max(glm::abs(surface.position), glm::abs(vec3(scene_from_object[3])));
    const vec3 in_object = glm::abs(mat3(scene_from_object) * glm::abs(surface.in_object));
    // Embree's curves are met where an iteration ends; what rounds is as with triangles.
    return {.position = surface.position,
            .normal = hit.geometric_normal, // of an ellipsoid its own: rays into it begin within, and leave it
            .offset_m = 1e-3f * surface.radius_m + 4e-7f * glm::length(glm::max(reach, in_object))};
}

vec3 strand_arrival_point(const Strands& strands, const mat4& scene_from_object, const Hit& hit,
                          const vec3& direction) {
    const SpawnPoint spawn = strand_spawn_point(strands, scene_from_object, hit);
    if (strands.form() == StrandForm::Spheres)
        return spawn.towards(-direction);
    return spawn.position - (2.0f * surface_of(strands, hit, scene_from_object).radius_m + spawn.offset_m) * direction;
}

/// What of `way` is at right angles to a strand, of unit length; of a sphere, which has no tangent, 0.
static vec3 across(const vec3& tangent, const vec3& way) {
    const float squared = glm::dot(tangent, tangent);
    const vec3 share = squared > 0.0f ? way - glm::dot(way, tangent) / squared * tangent : vec3(0.0f);
    const float length = glm::length(share);
    return length > 0.0f ? share / length : vec3(0.0f);
}

void look_up_strand(const Strands& strands, const mat3& scene_from_object, const vec3& direction, const vec3& in_object,
                    const Hit& hit, std::span<const std::string> names, std::vector<vec2>& values) {
    const auto segment = static_cast<std::uint32_t>(hit.cell);
    const vec3 tangent = scene_from_object * strands.on_spline(segment, hit.barycentrics.x).tangent;
    for (const std::string& name : names)
        values.push_back(
            strands.look_up(name, segment, hit.barycentrics, across(tangent, -direction), tangent, in_object));
}

SpawnPoint other_side_spawn_point(const Scene& scene, const Hit& hit, const SpawnPoint& spawn) {
    const PlacedShape* placed = scene.placed_shape(hit.instance);
    const Strands* strands = placed != nullptr ? scene.description().shapes[placed->shape_index]->strands() : nullptr;
    if (strands == nullptr || strands->form() != StrandForm::Ribbon)
        return spawn;
    const StrandPoint at = strands->on_spline(static_cast<std::uint32_t>(hit.cell), hit.barycentrics.x);
    const vec3 centre(placed->world_from_object * vec4(at.centre, 1.0f)), aside = spawn.position - centre;
    const float aside_m = glm::length(aside);
    if (!(aside_m > 0.0f))
        return spawn;
    return {.position = centre, .normal = aside / aside_m, .offset_m = aside_m};
}
} // namespace tyndall
