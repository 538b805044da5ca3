// SPDX-License-Identifier: GPL-3.0-or-later
// What a hit asks its scene; ray_queries.cpp finds the hits.
#include "scene/attribute_pairs.hpp"
#include "scene/scene.hpp"
#include "scene/scene_surroundings.hpp"
#include "scene/strand_surface.hpp"
#include "scene/strands.hpp"
#include "shading/op_inputs.hpp"
#include "shading/pixel_steps.hpp"
#include "shading/surface_program.hpp"
#include <algorithm>
#include <array>

namespace tyndall {
const Material& Scene::material(std::uint32_t instance_index, std::uint32_t triangle) const {
    if (const PlacedShape* placed = placed_shape(instance_index))
        return description().materials[placed->material_index];
    const Instance& instance = description().instances[instance_index];
    return geometry_->slot_material(instance, description().meshes[instance.mesh_index]->arrays().slot_of(triangle));
}

const SharedMeshArrays& Scene::mesh_of(std::uint32_t instance) const {
    return description().meshes[description().instances[instance].mesh_index]->arrays();
}

bool Scene::is_smooth(std::uint32_t instance) const {
    if (const PlacedShape* placed = placed_shape(instance)) {
        const CellShape* cells = shape_of(*placed).cells();
        return cells != nullptr && cells->has_normals();
    }
    return !mesh_of(instance).corner_normals.empty();
}

template <typename Value>
static Value interpolate(const Value& a, const Value& b, const Value& c, vec2 barycentrics) {
    return a + barycentrics.x * (b - a) + barycentrics.y * (c - a);
}

/// The values of the material's UV maps and attributes at a hit; what the mesh lacks is (0, 0), as in Cycles.
static void look_up_uvs(const SharedMeshArrays& mesh, const Material& material, std::uint32_t triangle,
                        const vec2& barycentrics, const mat4& world_from_object, std::vector<vec2>& uvs) {
    for (const std::string& name : material.uv_map_names) {
        const SharedMeshArrays::UvMap* map = mesh.uv_map(name);
        if (map == nullptr) {
            uvs.push_back(strand_maps::of_edge(name, mesh, triangle, world_from_object));
            continue;
        }
        const vec2* corner = &map->corner_uvs[std::size_t{3} * triangle];
        uvs.push_back(interpolate(corner[0], corner[1], corner[2], barycentrics));
    }
}

/// What a step in a triangle's plane adds to barycentric coordinates.
static vec2 barycentric_step(const vec3& first_edge, const vec3& second_edge, const vec3& step) {
    const float a = glm::dot(first_edge, first_edge), b = glm::dot(first_edge, second_edge),
                c = glm::dot(second_edge, second_edge), determinant = a * c - b * b;
    if (!(determinant > 0.0f))
        return vec2(0.0f);
    const float along_first = glm::dot(first_edge, step), along_second = glm::dot(second_edge, step);
    return vec2(c * along_first - b * along_second, a * along_second - b * along_first) / determinant;
}

/// Some operation of the material wants to know what lies beside the point, as bumps do.
static bool reads_beside(const Material& material) {
    return std::ranges::any_of(material.program, [](const SurfaceOp& op) { return op.shift != 0; });
}

static bool reads_edges(const Material& material) {
    return std::ranges::any_of(material.program,
                               [](const SurfaceOp& op) { return reads(op, PointInput::EdgeDistance); });
}

/// From a point within a triangle to the nearest of its edges, whose ends are placed by `to_scene`.
static float edge_distance(const SharedMeshArrays& mesh, const mat3& to_scene, const Hit& hit) {
    const uvec3& corners = mesh.triangles[hit.triangle];
    const vec3 first = to_scene * (mesh.positions[corners.y] - mesh.positions[corners.x]),
               second = to_scene * (mesh.positions[corners.z] - mesh.positions[corners.x]);
    const float twice_area = glm::length(glm::cross(first, second));
    const vec2& across = hit.barycentrics; // shares of the way to each edge from the corner that is not on it
    return twice_area * std::min({(1.0f - across.x - across.y) / glm::length(second - first),
                                  across.x / glm::length(second), across.y / glm::length(first)});
}

static float view_cosine(const ShadingPoint& point, const Ray& ray) {
    return std::clamp(-glm::dot(point.shading_normal, ray.direction), 0.0f, 1.0f);
}

/// The colour of cells is the attribute of this name, as meshes that are made of them have it, and the active one.
static constexpr std::string_view cell_color_name = "Color";
static bool is_cell_color(std::string_view attribute) { return attribute.empty() || attribute == cell_color_name; }

static bool reads_cell_color(const Material& material) {
    return std::ranges::any_of(material.uv_map_names, [](const std::string& name) {
        return name.starts_with(attribute_pairs::red_green) &&
               is_cell_color(std::string_view(name).substr(attribute_pairs::red_green.size()));
    });
}

/// The same of a cell, which has attributes, but no UV maps.
static void look_up_uvs(const CellShape& shape, const CellLook& look, const Material& material,
                        std::vector<vec2>& uvs) {
    const std::span<const std::string> channels = shape.channel_names();
    for (const std::string_view name : material.uv_map_names) {
        const bool is_first = name.starts_with(attribute_pairs::red_green);
        if (!is_first && !name.starts_with(attribute_pairs::blue_alpha)) {
            uvs.emplace_back(0.0f);
            continue;
        }
        const std::string_view attribute = name.substr(attribute_pairs::red_green.size());
        vec4 value(0.0f);
        if (is_cell_color(attribute))
            value = vec4(look.color, 1.0f);
        else if (const auto found = std::ranges::find(channels, attribute); found != channels.end())
            value = vec4(vec3(look.channels[static_cast<std::size_t>(found - channels.begin())]), 1.0f);
        uvs.push_back(is_first ? vec2(value.x, value.y) : vec2(value.z, value.w));
    }
}

const ShapeGeometry& Scene::shape_of(const PlacedShape& placed) const {
    return *description().shapes[placed.shape_index];
}

ShadingPoint Scene::shading_point(const PlacedShape& placed, const Ray& ray, const Hit& hit) const {
    if (const Strands* strands = shape_of(placed).strands()) {
        ShadingPoint point = strand_shading_point(*strands, placed.world_from_object, ray, hit);
        point.view_cosine = view_cosine(point, ray);
        return point;
    }
    const CellShape& shape = *shape_of(placed).cells();
    const CellFace face = shape.face(hit.cell);
    const vec3 in_object = face.corner + hit.barycentrics.x * face.first_edge + hit.barycentrics.y * face.second_edge;
    ShadingPoint point{.position = vec3(placed.world_from_object * vec4(in_object, 1.0f)),
                       .geometric_normal = hit.geometric_normal,
                       .shading_normal = hit.geometric_normal,
                       .triangle = hit.triangle,
                       .barycentrics = hit.barycentrics,
                       .is_backface = glm::dot(hit.geometric_normal, ray.direction) > 0.0f};
    const CellLook look = shape.look(hit.cell);
    if (!reads_cell_color(description().materials[placed.material_index]))
        point.tint = look.color;
    const vec3 normal = normal_in_scene(hit.instance, look.normal);
    if (const float length = glm::length(normal); length > 0.0f)
        point.shading_normal = normal / length;
    // Walls of one voxel have two sides. Steps at a silhouette look away from the ray a little, and stay as they are; the
    // faces of cubes of voxels say nothing about the surface in them.
    if (shape.is_cube(hit.cell) ? glm::dot(point.shading_normal, ray.direction) > 0.0f
                                : glm::dot(point.shading_normal, point.geometric_normal) < 0.0f)
        point.shading_normal = -point.shading_normal;
    point.view_cosine = view_cosine(point, ray);
    return point;
}

ShadingPoint Scene::shading_point(const Ray& ray, const Hit& hit) const {
    if (const PlacedShape* placed = placed_shape(hit.instance))
        return shading_point(*placed, ray, hit);
    const Instance& instance = description().instances[hit.instance];
    const SharedMeshArrays& mesh = description().meshes[instance.mesh_index]->arrays();
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
        point.is_smooth = true;
        const mat3 to_scene = normal_matrix(geometry_->objects_from_scene[hit.instance]);
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
    point.view_cosine = view_cosine(point, ray);
    return point;
}

/// In the object's space, not of unit length; zero where the mesh is flat.
static vec3 smooth_normal(const SharedMeshArrays& mesh, const Hit& hit) {
    if (mesh.corner_normals.empty())
        return vec3(0.0f);
    const vec3* corner = &mesh.corner_normals[std::size_t{3} * hit.triangle];
    return interpolate(corner[0], corner[1], corner[2], hit.barycentrics);
}

ProgramPoint Scene::program_point(const AskingRay& asking, const ShadingPoint& point, const Hit& hit,
                                  const Material& surface) const {
    const PlacedShape* const placed = placed_shape(hit.instance);
    const mat4& object_from_scene = geometry_->objects_from_scene[hit.instance];
    const std::vector<ObjectInfo>& infos = description().object_infos;
    const float random = placed != nullptr ? placed->random : description().instances[hit.instance].random;
    ProgramPoint at{.surface = point,
                    .ray_kind = asking.kind,
                    .is_of_light = asking.is_of_light,
                    .incoming = -asking.ray.direction,
                    .ray_length_m = hit.distance_m - asking.ray.near_m,
                    .passed_count = asking.ray.passed_count,
                    .footprint_m = asking.footprint_m,
                    .object_position = vec3(object_from_scene * vec4(point.position, 1.0f)),
                    .origin_in_world = vec3(description().origin_in_world),
                    .object = {.scene_from_object = placed != nullptr
                                                        ? &placed->world_from_object
                                                        : &description().instances[hit.instance].world_from_object,
                               .object_from_scene = &object_from_scene,
                               .info = infos.empty() ? nullptr : &infos[description().name_index_of(hit.instance)],
                               .random = random,
                               .particle = description().particle_of(hit.instance),
                               .instancer_values = description().instancer_values_of(hit.instance)},
                    .object_normal = placed != nullptr ? vec3(0.0f) : smooth_normal(mesh_of(hit.instance), hit)};
    if (placed == nullptr && reads_edges(surface))
        at.edge_distance_m = edge_distance(mesh_of(hit.instance), mat3(*at.object.scene_from_object), hit);
    return at;
}

void Scene::look_up_uvs(const AskingRay& asking, const ProgramPoint& at, const Hit& hit, const Material& surface,
                        std::vector<vec2>& uvs) const {
    const PlacedShape* const placed = placed_shape(hit.instance);
    if (placed == nullptr)
        return tyndall::look_up_uvs(mesh_of(hit.instance), surface, hit.triangle, hit.barycentrics,
                                    description().instances[hit.instance].world_from_object, uvs);
    const ShapeGeometry& shape = shape_of(*placed);
    if (const Strands* const strands = shape.strands())
        look_up_strand(*strands, mat3(placed->world_from_object), asking.ray.direction, at.object_position, hit,
                       surface.uv_map_names, uvs);
    else
        tyndall::look_up_uvs(*shape.cells(), shape.cells()->look(hit.cell), surface, uvs);
}

SurfaceClosures Scene::closures(const AskingRay& asking, const ShadingPoint& point, const Hit& hit,
                                std::vector<Lobe>* lobes) const {
    const Material& surface = asking.material != nullptr ? *asking.material : material(hit.instance, hit.triangle);
    if (!surface.has_surface)
        return {.diffuse_albedo = Rgb(0.0f), .transparent = Rgb(1.0f), .emission = Rgb(0.0f)};
    SurfaceClosures closures = surface.constant;
    const PlacedShape* const placed = placed_shape(hit.instance);
    if (surface.is_constant() && !surface.gloss && surface.lobe_sources.empty()) { // most surfaces, without a call
        closures.diffuse_albedo *= point.tint;
    } else if (surface.is_constant()) {
        closures =
            evaluate(surface, {.surface = point, .is_of_light = asking.is_of_light, .incoming = -asking.ray.direction},
                     {}, lobes);
    } else {
        thread_local std::vector<vec2> uvs;
        uvs.clear();
        ProgramPoint at = program_point(asking, point, hit, surface);
        const SceneSurroundings surroundings(*this, asking, point, hit);
        if (asking.random)
            at.surroundings = &surroundings;
        look_up_uvs(asking, at, hit, surface, uvs);
        if (placed == nullptr && at.footprint_m > 0.0f && reads_beside(surface)) {
            const SharedMeshArrays& mesh = mesh_of(hit.instance);
            const mat4& world_from_object = description().instances[hit.instance].world_from_object;
            const uvec3& corners = mesh.triangles[hit.triangle];
            const mat3 to_scene(world_from_object);
            const vec3 first_edge = to_scene * (mesh.positions[corners.y] - mesh.positions[corners.x]),
                       second_edge = to_scene * (mesh.positions[corners.z] - mesh.positions[corners.x]);
            for (const vec3& step : pixel_steps(at))
                tyndall::look_up_uvs(mesh, surface, hit.triangle,
                                     hit.barycentrics + barycentric_step(first_edge, second_edge, step),
                                     world_from_object, uvs);
        }
        closures = evaluate(surface, at, uvs, lobes);
    }
    if (placed != nullptr && shape_of(*placed).cells() != nullptr)
        closures.transparent = Rgb(0.0f);
    return closures;
}

Rgb Scene::emission_of(const CellLook& look, const Ray& ray, RayKind kind, const Hit& hit) const {
    const Material& surface = material(hit.instance, hit.triangle);
    if (surface.is_constant())
        return constant_emission(surface);
    ShadingPoint point{.position = ray.origin + hit.distance_m * ray.direction,
                       .geometric_normal = hit.geometric_normal,
                       .shading_normal = hit.geometric_normal};
    point.view_cosine = view_cosine(point, ray);
    thread_local std::vector<vec2> uvs;
    uvs.clear();
    tyndall::look_up_uvs(*shape_of(*placed_shape(hit.instance)).cells(), look, surface, uvs);
    return evaluate(surface, program_point({.ray = ray, .kind = kind, .is_of_light = true}, point, hit, surface), uvs)
        .emission;
}

SurfaceClosures Scene::closures(const Ray& ray, const Hit& hit) const {
    return closures({.ray = ray}, shading_point(ray, hit), hit);
}

bool Scene::is_opaque(const Hit& hit) const {
    const PlacedShape* const placed = placed_shape(hit.instance);
    if (placed != nullptr && shape_of(*placed).cells() != nullptr)
        return true;
    const Material& surface = material(hit.instance, hit.triangle);
    return surface.has_surface && is_opaque_everywhere(surface);
}

const TransparentOperations& Scene::Geometry::transparent_operations_of(const Material& material) const {
    return transparent_operations[static_cast<std::size_t>(&material - description.materials.data())];
}

std::optional<Rgb> Scene::even_transparency(const Hit& hit) const {
    const PlacedShape* const placed = placed_shape(hit.instance);
    if (placed != nullptr && shape_of(*placed).cells() != nullptr)
        return Rgb(0.0f);
    const Material& surface = material(hit.instance, hit.triangle);
    if (!surface.has_surface)
        return Rgb(1.0f);
    return geometry_->transparent_operations_of(surface).constant;
}

Rgb Scene::transparency(const Ray& ray, const Hit& hit, RayKind kind) const {
    if (const std::optional<Rgb> even = even_transparency(hit))
        return *even;
    const Material& surface = material(hit.instance, hit.triangle);
    const AskingRay asking{.ray = ray, .kind = kind};
    const ShadingPoint point = shading_point(ray, hit);
    const ProgramPoint at = program_point(asking, point, hit, surface);
    thread_local std::vector<vec2> uvs;
    uvs.clear();
    look_up_uvs(asking, at, hit, surface, uvs);
    return evaluate_transparent(surface, geometry_->transparent_operations_of(surface), at, uvs);
}

Rgb Scene::passing_share(const Ray& ray, const Hit& hit, RayKind kind) const {
    const std::optional<Rgb> even = even_transparency(hit);
    const Rgb once = even ? *even : transparency(ray, in_scene(ray, hit), kind);
    const PlacedShape* const placed = placed_shape(hit.instance);
    const Strands* const strands = placed != nullptr ? shape_of(*placed).strands() : nullptr;
    return strands != nullptr && strands->layers() == 2 ? once * once : once;
}

SpawnPoint Scene::spawn_point(const Hit& hit) const {
    const mat4& object_from_scene = geometry_->objects_from_scene[hit.instance];
    if (const PlacedShape* placed = placed_shape(hit.instance)) {
        if (const Strands* strands = shape_of(*placed).strands())
            return strand_spawn_point(*strands, placed->world_from_object, hit);
        const auto [corner, first_edge, second_edge] = shape_of(*placed).cells()->face(hit.cell);
        return tyndall::spawn_point({corner, corner + first_edge, corner + second_edge}, hit.barycentrics,
                                    placed->world_from_object, object_from_scene);
    }
    const Instance& instance = description().instances[hit.instance];
    const SharedMeshArrays& mesh = description().meshes[instance.mesh_index]->arrays();
    const uvec3& corners = mesh.triangles[hit.triangle];
    return tyndall::spawn_point({mesh.positions[corners.x], mesh.positions[corners.y], mesh.positions[corners.z]},
                                hit.barycentrics, instance.world_from_object, object_from_scene);
}

vec3 Scene::arrival_point(const Hit& hit, const vec3& direction) const {
    const PlacedShape* const placed = placed_shape(hit.instance);
    if (const Strands* strands = placed != nullptr ? shape_of(*placed).strands() : nullptr)
        return strand_arrival_point(*strands, placed->world_from_object, hit, direction);
    return spawn_point(hit).towards(-direction);
}

bool Scene::is_cube(const Hit& hit) const {
    const PlacedShape* placed = placed_shape(hit.instance);
    const CellShape* cells = placed != nullptr ? shape_of(*placed).cells() : nullptr;
    return cells != nullptr && cells->is_cube(hit.cell);
}

SpawnPoint Scene::spawn_point(const Ray& ray, const Hit& hit, const ShadingPoint& shading) const {
    SpawnPoint spawn = spawn_point(hit);
    if (!is_cube(hit))
        return spawn;
    const PlacedShape& placed = *placed_shape(hit.instance);
    const CellShape& shape = *shape_of(placed).cells();
    const Bounds3 box = shape.box(hit.cell);
    std::array<vec3, 8> corners;
    for (std::size_t i = 0; i < corners.size(); ++i)
        corners[i] = vec3(placed.world_from_object * vec4(box.corner(i), 1.0f));
    vec3 outwards = shading.shading_normal;
    if (!shape.has_normals()) { // then any normal that looks to the viewer may be that of the surface in it
        const vec3 nearest =
            *std::ranges::min_element(corners, {}, [&](const vec3& corner) { return glm::dot(corner, ray.direction); });
        outwards = glm::normalize(nearest - vec3(placed.world_from_object * vec4(box.centre(), 1.0f)));
    }
    float lift_m = 0.0f;
    for (const vec3& corner : corners)
        lift_m = std::max(lift_m, glm::dot(corner - spawn.position, outwards));
    spawn.position += lift_m * outwards;
    spawn.normal = outwards;
    return spawn;
}

Ray Scene::leaving_ray(const Hit& hit, const vec3& direction, float far_m) const {
    return {.origin = spawn_point(hit).towards(direction), .direction = direction, .near_m = 0.0f, .far_m = far_m};
}
} // namespace tyndall
