// SPDX-License-Identifier: GPL-3.0-or-later
// What rays ask a scene.
#include "scene/instance_masks.hpp"
#include "scene/scene.hpp"
#include "scene/spawn_offset.hpp"
#include "shading/surface_program.hpp"
#include <algorithm>
#include <array>

namespace tyndall {
static RTCRay embree_ray(const Ray& ray, unsigned int mask) {
    RTCRay result{};
    result.org_x = ray.origin.x;
    result.org_y = ray.origin.y;
    result.org_z = ray.origin.z;
    result.tnear = ray.near_m;
    result.dir_x = ray.direction.x;
    result.dir_y = ray.direction.y;
    result.dir_z = ray.direction.z;
    result.tfar = ray.far_m;
    result.mask = mask;
    return result;
}

/// Embree's context, and behind it what the filters need: Embree hands them the pointer to the context.
struct QueryContext {
    RTCIntersectContext embree;
    const Scene* scene;
    const Ray* ray;
    Rgb transmittance{1.0f};
};

static Hit hit_of(const RTCRay& ray, const RTCHit& hit) {
    return {.distance_m = ray.tfar,
            .instance = hit.instID[0],
            .triangle = hit.primID,
            .barycentrics = vec2(hit.u, hit.v),
            .geometric_normal = vec3(hit.Ng_x, hit.Ng_y, hit.Ng_z)};
}

/// Lets view rays through triangles whose slot has no surface, on an instance that has surfaces elsewhere.
static void skip_holes(const RTCFilterFunctionNArguments* arguments) {
    const auto& context = *reinterpret_cast<const QueryContext*>(arguments->context);
    const auto& hit = *reinterpret_cast<const RTCHit*>(arguments->hit);
    if (!context.scene->material(hit.instID[0], hit.primID).has_surface)
        arguments->valid[0] = 0;
}

/// Multiplies the transmittance of a transparent hit into the context and goes on; an opaque one ends the ray.
static void attenuate(const RTCFilterFunctionNArguments* arguments) {
    auto& context = *reinterpret_cast<QueryContext*>(arguments->context);
    const auto& hit = *reinterpret_cast<const RTCHit*>(arguments->hit);
    context.transmittance *=
        context.scene->transparency(*context.ray, hit_of(*reinterpret_cast<const RTCRay*>(arguments->ray), hit));
    if (context.transmittance != Rgb(0.0f))
        arguments->valid[0] = 0;
}

Hit Scene::closest_hit(const Ray& ray) const {
    QueryContext context{.embree = {}, .scene = this, .ray = &ray};
    rtcInitIntersectContext(&context.embree);
    if (has_holes_)
        context.embree.filter = skip_holes;
    RTCRayHit query;
    query.ray = embree_ray(ray, camera_mask);
    query.hit.geomID = query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(embree_scene_, &context.embree, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID)
        return {};
    Hit hit = hit_of(query.ray, query.hit);
    hit.geometric_normal = glm::normalize(placements_[hit.instance].scene_from_object_normals * hit.geometric_normal);
    return hit;
}

Rgb Scene::shadow_transmittance(const Ray& ray) const {
    QueryContext context{.embree = {}, .scene = this, .ray = &ray};
    rtcInitIntersectContext(&context.embree);
    if (lets_light_pass_)
        context.embree.filter = attenuate;
    RTCRay query = embree_ray(ray, shadow_mask);
    rtcOccluded1(embree_scene_, &context.embree, &query);
    const bool is_occluded = query.tfar < 0.0f;
    return is_occluded ? Rgb(0.0f) : context.transmittance;
}

const Material& Scene::material(std::uint32_t instance_index, std::uint32_t triangle) const {
    const Instance& instance = description_.instances[instance_index];
    const std::vector<std::uint16_t>& slots = description_.meshes[instance.mesh_index]->arrays().material_slots;
    return slot_material(instance, slots.empty() ? 0 : slots[triangle]);
}

template <typename Value>
static Value interpolate(const Value& a, const Value& b, const Value& c, vec2 barycentrics) {
    return a + barycentrics.x * (b - a) + barycentrics.y * (c - a);
}

/// The values of the material's UV maps at a hit; a map that the mesh lacks is (0, 0), as in Cycles.
static void look_up_uvs(const Material& material, const MeshArrays& mesh, const Hit& hit, std::vector<vec2>& uvs) {
    for (const std::string& name : material.uv_map_names) {
        const auto map = name.empty() ? mesh.uv_maps.begin()
                                      : std::find_if(mesh.uv_maps.begin(), mesh.uv_maps.end(),
                                                     [&](const MeshArrays::UvMap& m) { return m.name == name; });
        if (map == mesh.uv_maps.end()) {
            uvs.emplace_back(0.0f);
            continue;
        }
        const vec2* corner = &map->corner_uvs[std::size_t{3} * hit.triangle];
        uvs.push_back(interpolate(corner[0], corner[1], corner[2], hit.barycentrics));
    }
}

ShadingPoint Scene::shading_point(const Ray& ray, const Hit& hit) const {
    const Instance& instance = description_.instances[hit.instance];
    const MeshArrays& mesh = description_.meshes[instance.mesh_index]->arrays();
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
        const mat3& to_scene = placements_[hit.instance].scene_from_object_normals;
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

SurfaceClosures Scene::closures(const Ray& ray, const Hit& hit) const {
    const Material& surface = material(hit.instance, hit.triangle);
    if (!surface.has_surface)
        return {.diffuse_albedo = Rgb(0.0f), .transparent = Rgb(1.0f), .emission = Rgb(0.0f)};
    if (surface.is_constant())
        return surface.constant;
    thread_local std::vector<vec2> uvs;
    uvs.clear();
    const ShadingPoint point = shading_point(ray, hit);
    look_up_uvs(surface, description_.meshes[point.mesh_index]->arrays(), hit, uvs);
    return evaluate(surface, point, uvs);
}

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
    const MeshArrays& mesh = description_.meshes[description_.instances[hit.instance].mesh_index]->arrays();
    look_up_uvs(surface, mesh, hit, uvs);
    Hit with_normal = hit;
    with_normal.geometric_normal =
        glm::normalize(placements_[hit.instance].scene_from_object_normals * hit.geometric_normal);
    return evaluate_transparent(surface, shading_point(ray, with_normal), uvs);
}

Ray Scene::leaving_ray(const Hit& hit, const vec3& direction, float far_m) const {
    const Instance& instance = description_.instances[hit.instance];
    const MeshArrays& mesh = description_.meshes[instance.mesh_index]->arrays();
    const uvec3& corners = mesh.triangles[hit.triangle];
    const SpawnPoint spawn =
        spawn_point({mesh.positions[corners.x], mesh.positions[corners.y], mesh.positions[corners.z]}, hit.barycentrics,
                    instance.world_from_object, placements_[hit.instance].object_from_scene);
    return {.origin = spawn.towards(direction), .direction = direction, .near_m = 0.0f, .far_m = far_m};
}
} // namespace tyndall
