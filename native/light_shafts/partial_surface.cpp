// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/partial_surface.hpp"
#include "core/random.hpp"
#include "core/sobol.hpp"
#include "shading/pixel_steps.hpp"
#include <algorithm>
#include <bit>

namespace tyndall::light_shafts {
static std::uint32_t hash_of(const vec3& v) {
    return hash(std::bit_cast<std::uint32_t>(v.x), std::bit_cast<std::uint32_t>(v.y),
                std::bit_cast<std::uint32_t>(v.z));
}

PartialShading::PartialShading(std::span<const PartialOccluderInstance> all, const LightSample& sample,
                               std::uint32_t frame_seed)
    : instances(all), light(sample),
      seed(hash(frame_seed, hash_of(sample.is_directional ? sample.towards_light : sample.position))) {}

static vec3 towards(const LightSample& light, const vec3& from) {
    if (light.is_directional)
        return light.towards_light;
    const vec3 way = light.position - from;
    const float length = glm::length(way);
    return length > 0.0f ? way / length : vec3(0, 0, 1);
}

/// As shadow rays see it, which go from the lit point to the light: they leave a triangle by its back.
static bool faces_away(const PartialOccluderInstance& instance, std::uint32_t triangle, const LightSample& light) {
    const SharedMeshArrays& arrays = *instance.mesh->arrays;
    const glm::dmat4 scene_from_object(*instance.scene_from_object);
    const auto corner = [&](int c) {
        return dvec3(scene_from_object * glm::dvec4(arrays.positions[arrays.triangles[triangle][c]], 1.0));
    };
    const dvec3 a = corner(0), normal = glm::cross(corner(1) - a, corner(2) - a);
    const dvec3 towards = light.is_directional ? dvec3(light.towards_light) : dvec3(light.position) - a;
    const bool is_mirrored = glm::determinant(glm::dmat3(scene_from_object)) < 0.0;
    return glm::dot(is_mirrored ? -normal : normal, towards) > 0.0;
}

PartialSurface partial_surface(const PartialShading& shading, std::uint32_t instance, std::uint32_t triangle,
                               std::int32_t slice) {
    const PartialOccluderInstance& placed = shading.instances[instance];
    const SharedMeshArrays& arrays = *placed.mesh->arrays;
    const std::size_t slot = arrays.slot_of(triangle);
    PartialSurface surface{.slot = &placed.mesh->slots[std::min(slot, placed.mesh->slots.size() - 1)],
                           .triangle = triangle,
                           .instance = placed.index,
                           .slice = static_cast<std::uint32_t>(slice + shading.first_slice),
                           .seed = shading.seed,
                           .channel = shading.channel};
    const TransparencyLookup& lookup = *surface.slot->lookup;
    surface.is_backface = lookup.reads_facing() && faces_away(placed, triangle, shading.light);
    if (lookup.reads_point()) {
        surface.placed = &placed;
        surface.light = &shading.light;
    }
    const SurfaceOp* image = lookup.image();
    if (image == nullptr)
        return surface;
    const vec2* corners = surface.slot->corner_uvs[image->texture_uv];
    const auto mapped = [&](std::size_t c) {
        return vec2(image->uv_matrix * vec3(corners == nullptr ? vec2(0.0f) : corners[3 * triangle + c], 1.0f));
    };
    surface.uv = mapped(0);
    surface.uv_run[0] = mapped(1) - surface.uv;
    surface.uv_run[1] = mapped(2) - surface.uv;
    return surface;
}

/// What the material's program may read of the point with these weights, as a shadow ray has it: it goes from what is lit
/// to the light.
static ProgramPoint program_point(const PartialSurface& surface, const vec2& weights) {
    ProgramPoint point{.surface = {.barycentrics = weights, .is_backface = surface.is_backface},
                       .ray_kind = RayKind::Shadow};
    if (surface.placed == nullptr)
        return point;
    const PartialOccluderInstance& placed = *surface.placed;
    const SharedMeshArrays& arrays = *placed.mesh->arrays;
    const mat4& scene_from_object = *placed.scene_from_object;
    const auto between = [&](const vec3& a, const vec3& b, const vec3& c) {
        return a + weights.x * (b - a) + weights.y * (c - a);
    };
    const uvec3& corners = arrays.triangles[surface.triangle];
    const vec3 &a = arrays.positions[corners.x], &b = arrays.positions[corners.y], &c = arrays.positions[corners.z];
    point.object = {&scene_from_object, &placed.object_from_scene, placed.info, placed.random, placed.particle};
    point.origin_in_world = placed.origin_in_world;
    point.object_position = between(a, b, c);
    point.surface.position = vec3(scene_from_object * vec4(point.object_position, 1.0f));
    point.surface.triangle = surface.triangle;
    point.incoming = -towards(*surface.light, point.surface.position);
    point.surface.geometric_normal = normal_in_scene(point, glm::cross(b - a, c - a));
    point.surface.shading_normal = point.surface.geometric_normal;
    if (!arrays.corner_normals.empty()) {
        const vec3* normals = &arrays.corner_normals[std::size_t{3} * surface.triangle];
        point.object_normal = between(normals[0], normals[1], normals[2]);
        if (point.object_normal != vec3(0.0f))
            point.surface.shading_normal = normal_in_scene(point, point.object_normal);
    }
    if (surface.is_backface)
        point.surface.shading_normal = -point.surface.shading_normal;
    point.surface.view_cosine = std::clamp(glm::dot(point.surface.shading_normal, point.incoming), 0.0f, 1.0f);
    return point;
}

float PartialSurface::transmittance(const vec2& weights) const {
    if (slot->lookup->is_straight())
        return slot->lookup->at(uv + weights.x * uv_run[0] + weights.y * uv_run[1])[channel];
    if (slot->lookup->is_straight_by_channel())
        return slot->lookup->at(uv + weights.x * uv_run[0] + weights.y * uv_run[1], channel);
    thread_local std::vector<vec2> uvs;
    uvs.clear();
    for (const vec2* corners : slot->corner_uvs) {
        const vec2* at = corners == nullptr ? nullptr : corners + std::size_t{3} * triangle;
        uvs.push_back(at == nullptr ? vec2(0.0f) : at[0] + weights.x * (at[1] - at[0]) + weights.y * (at[2] - at[0]));
    }
    return slot->lookup->at(program_point(*this, weights), uvs)[channel];
}

/// A number in [0, 1) per line: of the numbers of 2^k lines that begin at a multiple of 2^k, one lies in each 2^-k.
static float threshold(std::uint32_t seed, std::int32_t line) {
    return unit_float(laine_karras_permutation(reverse_bits(static_cast<std::uint32_t>(line)), seed));
}

bool PartialSurface::stops(float transmittance, std::int32_t line) const {
    if (transmittance <= 0.0f || transmittance >= 1.0f)
        return transmittance <= 0.0f;
    return threshold(hash(seed, instance, triangle, slice), line) >= transmittance;
}
} // namespace tyndall::light_shafts
