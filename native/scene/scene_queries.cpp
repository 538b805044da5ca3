// SPDX-License-Identifier: GPL-3.0-or-later
// What a hit asks its scene; ray_queries.cpp finds the hits.
#include "scene/scene.hpp"
#include "shading/surface_program.hpp"
#include <algorithm>
#include <array>

namespace tyndall {
const Material& Scene::material(std::uint32_t instance_index, std::uint32_t triangle) const {
    const Instance& instance = description().instances[instance_index];
    return geometry_->slot_material(instance, description().meshes[instance.mesh_index]->arrays().slot_of(triangle));
}

template <typename Value>
static Value interpolate(const Value& a, const Value& b, const Value& c, vec2 barycentrics) {
    return a + barycentrics.x * (b - a) + barycentrics.y * (c - a);
}

/// The values of the material's UV maps at a hit; a map that the mesh lacks is (0, 0), as in Cycles.
static void look_up_uvs(const Material& material, const MeshArrays& mesh, const Hit& hit, std::vector<vec2>& uvs) {
    for (const std::string& name : material.uv_map_names) {
        const MeshArrays::UvMap* map = mesh.uv_map(name);
        if (map == nullptr) {
            uvs.emplace_back(0.0f);
            continue;
        }
        const vec2* corner = &map->corner_uvs[std::size_t{3} * hit.triangle];
        uvs.push_back(interpolate(corner[0], corner[1], corner[2], hit.barycentrics));
    }
}

ShadingPoint Scene::shading_point(const Ray& ray, const Hit& hit) const {
    const Instance& instance = description().instances[hit.instance];
    const MeshArrays& mesh = description().meshes[instance.mesh_index]->arrays();
    const uvec3& corners = mesh.triangles[hit.triangle];
    const vec3 in_object =
        interpolate(mesh.positions[corners.x], mesh.positions[corners.y], mesh.positions[corners.z], hit.barycentrics);
    ShadingPoint point{.position = vec3(instance.world_from_object * vec4(in_object, 1.0f)),
                       .geometric_normal = hit.geometric_normal,
                       .shading_normal = hit.geometric_normal,
                       .mesh_index = instance.mesh_index,
                       .triangle = hit.triangle,
                       .barycentrics = hit.barycentrics,
                       .is_backface = glm::dot(hit.geometric_normal, ray.direction) > 0.0f};
    if (!mesh.corner_normals.empty()) {
        const mat3& to_scene = geometry_->placements[hit.instance].scene_from_object_normals;
        std::array<vec3, 3> normals;
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const vec3& normal = mesh.corner_normals[std::size_t{3} * hit.triangle + corner];
            // A zero vector asks for the flat normal, and so does, in effect, one that is not finite.
            const float length = glm::length(to_scene * normal);
            normals[corner] =
                length > 0.0f && std::isfinite(length) ? to_scene * normal / length : hit.geometric_normal;
        }
        const vec3 smooth = interpolate(normals[0], normals[1], normals[2], hit.barycentrics);
        const float length = glm::length(smooth);
        if (length > 0.0f)
            point.shading_normal = smooth / length;
    }
    if (point.is_backface)
        point.shading_normal = -point.shading_normal;
    return point;
}

SurfaceClosures Scene::closures(const ShadingPoint& point, const Hit& hit) const {
    const Material& surface = material(hit.instance, hit.triangle);
    if (!surface.has_surface)
        return {.diffuse_albedo = Rgb(0.0f), .transparent = Rgb(1.0f), .emission = Rgb(0.0f)};
    if (surface.is_constant())
        return surface.constant;
    thread_local std::vector<vec2> uvs;
    uvs.clear();
    look_up_uvs(surface, description().meshes[point.mesh_index]->arrays(), hit, uvs);
    return evaluate(surface, point, uvs);
}

SurfaceClosures Scene::closures(const Ray& ray, const Hit& hit) const { return closures(shading_point(ray, hit), hit); }

Rgb Scene::transparency(const Ray& ray, const Hit& hit) const {
    const Material& surface = material(hit.instance, hit.triangle);
    if (!surface.has_surface)
        return Rgb(1.0f);
    if (surface.is_constant())
        return surface.constant.transparent;
    if (is_opaque_everywhere(surface))
        return Rgb(0.0f);
    thread_local std::vector<vec2> uvs;
    uvs.clear();
    const MeshArrays& mesh = description().meshes[description().instances[hit.instance].mesh_index]->arrays();
    look_up_uvs(surface, mesh, hit, uvs);
    Hit with_normal = hit;
    with_normal.geometric_normal =
        glm::normalize(geometry_->placements[hit.instance].scene_from_object_normals * hit.geometric_normal);
    return evaluate_transparent(surface, shading_point(ray, with_normal), uvs);
}

SpawnPoint Scene::spawn_point(const Hit& hit) const {
    const Instance& instance = description().instances[hit.instance];
    const MeshArrays& mesh = description().meshes[instance.mesh_index]->arrays();
    const uvec3& corners = mesh.triangles[hit.triangle];
    return tyndall::spawn_point({mesh.positions[corners.x], mesh.positions[corners.y], mesh.positions[corners.z]},
                                hit.barycentrics, instance.world_from_object,
                                geometry_->placements[hit.instance].object_from_scene);
}

Ray Scene::leaving_ray(const Hit& hit, const vec3& direction, float far_m) const {
    return {.origin = spawn_point(hit).towards(direction), .direction = direction, .near_m = 0.0f, .far_m = far_m};
}
} // namespace tyndall
