// SPDX-License-Identifier: GPL-3.0-or-later
#include "bindings/arrays.hpp"
#include "bindings/bind.hpp"
#include "bindings/shared_arrays.hpp"
#include "core/errors.hpp"
#include "scene/embree.hpp"
#include "scene/light_texture.hpp"
#include "scene/scene.hpp"
#include "scene/strands.hpp"
#include "voxel_dag/voxel_shape.hpp"
#include <pybind11/stl.h>

namespace tyndall::bindings {
using namespace py::literals;

static std::shared_ptr<TriangleMesh> make_mesh(std::string name, const py::array& positions, const py::array& triangles,
                                               const std::optional<py::array>& material_slots,
                                               const std::optional<py::array>& corner_normals,
                                               const std::vector<std::pair<std::string, py::array>>& uv_maps,
                                               const Progress& progress, bool is_hasty) {
    static_assert(shared_slack_bytes >= SharedMeshArrays::position_slack_bytes);
    SharedMeshArrays arrays;
    arrays.name = std::move(name);
    arrays.positions = to_shared<vec3, float>(positions, {-1, 3}, "positions");
    arrays.triangles = to_shared<uvec3, std::uint32_t>(triangles, {-1, 3}, "triangles");
    if (material_slots)
        arrays.material_slots = to_shared<std::uint16_t, std::uint16_t>(*material_slots, {-1}, "material_slots");
    if (corner_normals)
        arrays.corner_normals = to_shared<vec3, float>(*corner_normals, {-1, 3, 3}, "corner_normals");
    for (const auto& [uv_name, uvs] : uv_maps)
        arrays.uv_maps.push_back({uv_name, to_shared<vec2, float>(uvs, {-1, 3, 2}, "UV map " + uv_name)});
    const TreeQuality quality = is_hasty ? TreeQuality::Hasty : TreeQuality::Best;
    return without_gil([&] { return std::make_shared<TriangleMesh>(std::move(arrays), progress, quality); });
}

static Light make_light(std::string name, int kind, const Triple& strength, const Triple& position, const Triple& axis,
                        const py::array& light_from_world_directions, float half_angle_rad, float radius_m,
                        float spot_half_angle_rad, float spot_blend, int spot_falloff, int body,
                        const std::array<float, 2>& half_size_m, bool is_ellipse, bool casts_shadow,
                        const std::array<bool, 3>& lights_surfaces, bool lights_catchers, bool scatters_in_media,
                        std::vector<OccluderEdit> occluder_edits,
                        const std::optional<std::shared_ptr<LightTexture>>& texture, std::uint8_t light_group,
                        const std::array<std::uint64_t, 2>& links,
                        const std::vector<std::array<std::uint16_t, 2>>& unlit_media) {
    Light light;
    light.name = std::move(name);
    light.kind = static_cast<LightKind>(kind);
    light.strength = to_vec3(strength);
    light.position = to_vec3(position);
    light.towards_light = -to_vec3(axis);
    light.spot_axis = to_vec3(axis);
    light.half_angle_rad = half_angle_rad;
    light.radius_m = radius_m;
    light.spot_half_angle_rad = spot_half_angle_rad;
    light.spot_blend = spot_blend;
    light.spot_falloff = static_cast<SpotFalloff>(spot_falloff);
    light.body = static_cast<LightBody>(body);
    light.half_size_m = {half_size_m[0], half_size_m[1]};
    light.is_ellipse = is_ellipse;
    light.light_from_world_directions = to_matrix<mat3, 3>(light_from_world_directions, "light_from_world_directions");
    light.casts_shadow = casts_shadow;
    light.lights_surfaces = {lights_surfaces[0], lights_surfaces[1], lights_surfaces[2]};
    light.lights_catchers = lights_catchers;
    light.scatters_in_media = scatters_in_media;
    light.occluder_edits = std::move(occluder_edits);
    light.texture = texture.value_or(nullptr);
    light.light_group = light_group;
    light.links = {links[0], links[1]};
    for (const auto& [medium, dark] : unlit_media)
        light.unlit_media.push_back({medium, dark});
    return light;
}

static std::shared_ptr<const EnvironmentImage>
environment_image(const std::string& name, const std::optional<py::array>& pixels, const char* argument) {
    if (!pixels)
        return nullptr;
    auto image = std::make_shared<EnvironmentImage>();
    image->name = name;
    image->pixels = to_shared<vec4, float>(*pixels, {-1, -1, 4}, argument);
    image->height = static_cast<std::uint32_t>(pixels->shape(0));
    image->width = static_cast<std::uint32_t>(pixels->shape(1));
    return image;
}

static World make_world(std::string name, const Triple& radiance, const std::optional<py::array>& pixels,
                        const py::array& image_from_world, const std::optional<py::array>& seen_pixels,
                        const std::optional<std::shared_ptr<DirectionProgram>>& seen_program, std::uint8_t light_group,
                        const std::array<bool, 3>& lights_surfaces, bool scatters_in_media) {
    auto image = environment_image(name, pixels, "pixels");
    SeenWorld seen{.image = environment_image(name, seen_pixels, "seen_pixels"),
                   .program = seen_program.value_or(nullptr)};
    const mat3 rotation = to_matrix<mat3, 3>(image_from_world, "image_from_world");
    World world = without_gil(
        [&] { return World(std::move(name), to_vec3(radiance), std::move(image), rotation, std::move(seen)); });
    world.set_light_group(light_group);
    world.set_lit({lights_surfaces[0], lights_surfaces[1], lights_surfaces[2]}, scatters_in_media);
    return world;
}

namespace {
/// Placements in parallel arrays, one entry per instance.
struct InstanceArrays {
    std::vector<std::uint32_t> mesh_indices, name_indices, first_slot_materials;
    std::vector<std::uint16_t> slot_counts;
    std::vector<std::uint8_t> shows_to;
    std::vector<float> randoms;
    py::array world_from_object;
};
} // namespace

/// Of shows_to, beside the masks of kinds of rays.
static constexpr unsigned int held_out_flag = 32u, shadow_catcher_flag = 64u, lights_media_flag = 128u;

static std::vector<Instance> make_instances(const InstanceArrays& arrays) {
    const auto count = static_cast<py::ssize_t>(arrays.mesh_indices.size());
    check_array<float>(arrays.world_from_object, {count, 4, 4}, "world_from_object");
    const auto* matrices = static_cast<const float*>(arrays.world_from_object.data());
    std::vector<Instance> instances(arrays.mesh_indices.size());
    for (std::size_t i = 0; i < instances.size(); ++i)
        instances[i] = {.mesh_index = arrays.mesh_indices[i],
                        .world_from_object = to_matrix<mat4, 4>(matrices + 16 * i),
                        .name_index = arrays.name_indices[i],
                        .first_slot_material = arrays.first_slot_materials[i],
                        .slot_count = arrays.slot_counts[i],
                        .is_camera_visible = (arrays.shows_to[i] & camera_mask) != 0,
                        .casts_shadow = (arrays.shows_to[i] & shadow_mask) != 0,
                        .is_bounce_visible = (arrays.shows_to[i] & bounce_mask) != 0,
                        .is_mirror_visible = (arrays.shows_to[i] & mirror_mask) != 0,
                        .is_glass_visible = (arrays.shows_to[i] & glass_mask) != 0,
                        .lights_media = (arrays.shows_to[i] & lights_media_flag) != 0,
                        .is_held_out = (arrays.shows_to[i] & held_out_flag) != 0,
                        .is_shadow_catcher = (arrays.shows_to[i] & shadow_catcher_flag) != 0,
                        .random = arrays.randoms[i]};
    return instances;
}

/// Voxel objects and strands in parallel arrays, one entry per placement; their names follow those of the instances.
static std::vector<PlacedShape> make_placed_shapes(const py::array& shape_indices, const py::array& materials,
                                                   const py::array& shows_to, const py::array& randoms,
                                                   const py::array& world_from_object, std::size_t name_count) {
    const auto shapes = to_vector<std::uint32_t, std::uint32_t>(shape_indices, {-1}, "shape_indices");
    const auto count = static_cast<py::ssize_t>(shapes.size());
    const auto material = to_vector<std::uint32_t, std::uint32_t>(materials, {count}, "shape_materials");
    const auto mask = to_vector<std::uint8_t, std::uint8_t>(shows_to, {count}, "shape_shows_to");
    const auto random = to_vector<float, float>(randoms, {count}, "shape_randoms");
    check_array<float>(world_from_object, {count, 4, 4}, "world_from_shape");
    require(shapes.size() <= name_count, "there are ", name_count, " object_names for ", shapes.size(), " shapes");
    const auto* matrices = static_cast<const float*>(world_from_object.data());
    std::vector<PlacedShape> placed(shapes.size());
    for (std::size_t i = 0; i < placed.size(); ++i)
        placed[i] = {.shape_index = shapes[i],
                     .world_from_object = to_matrix<mat4, 4>(matrices + 16 * i),
                     .name_index = static_cast<std::uint32_t>(name_count - placed.size() + i),
                     .material_index = material[i],
                     .is_camera_visible = (mask[i] & camera_mask) != 0,
                     .casts_shadow = (mask[i] & shadow_mask) != 0,
                     .is_bounce_visible = (mask[i] & bounce_mask) != 0,
                     .is_mirror_visible = (mask[i] & mirror_mask) != 0,
                     .is_glass_visible = (mask[i] & glass_mask) != 0,
                     .lights_media = (mask[i] & lights_media_flag) != 0,
                     .is_held_out = (mask[i] & held_out_flag) != 0,
                     .is_shadow_catcher = (mask[i] & shadow_catcher_flag) != 0,
                     .random = random[i]};
    return placed;
}

static std::vector<ObjectInfo> make_object_infos(std::size_t count, const py::array& light_groups,
                                                 const py::array& sets, const py::array& links) {
    const auto size = static_cast<py::ssize_t>(count);
    const auto groups = to_vector<std::uint8_t, std::uint8_t>(light_groups, {size}, "object_light_groups");
    using Sets = std::array<std::uint8_t, 2>;
    const auto sets_of = to_vector<Sets, std::uint8_t>(sets, {size, 2}, "object_sets");
    using Masks = std::array<std::uint64_t, 2>;
    const auto links_of = to_vector<Masks, std::uint64_t>(links, {size, 2}, "object_links");
    std::vector<ObjectInfo> infos(count);
    for (std::size_t i = 0; i < count; ++i) {
        infos[i].light_group = groups[i];
        infos[i].receiver_set = sets_of[i][0];
        infos[i].blocker_set = sets_of[i][1];
        infos[i].links = {links_of[i][0], links_of[i][1]};
    }
    return infos;
}

static std::unique_ptr<SceneWithMedia>
make_scene(const std::array<double, 3>& origin_in_world, const std::vector<std::shared_ptr<TriangleMesh>>& meshes,
           const py::array& mesh_indices, const py::array& world_from_object, std::vector<std::string> object_names,
           const py::array& name_indices, const py::array& first_slot_materials, const py::array& slot_counts,
           const py::array& shows_to, const py::array& slot_materials, const py::array& randoms,
           const py::array& object_colors, const py::array& object_indices, const py::array& object_light_groups,
           const py::array& object_sets, const py::array& object_links,
           const std::vector<std::shared_ptr<ShapeGeometry>>& shapes, const py::array& shape_indices,
           const py::array& world_from_shape, const py::array& shape_materials, const py::array& shape_shows_to,
           const py::array& shape_randoms, std::vector<Material> materials, std::vector<Medium> media,
           std::vector<VolumeInstance> volumes, std::int32_t world_medium, const py::array& particles,
           const py::array& instance_particles, const py::array& instancer_values, const py::array& instancer_rows,
           const Progress& progress) {
    const py::ssize_t count = mesh_indices.size();
    SceneDescription description;
    description.origin_in_world = {origin_in_world[0], origin_in_world[1], origin_in_world[2]};
    description.meshes.assign(meshes.begin(), meshes.end());
    description.instances =
        make_instances({.mesh_indices = to_vector<std::uint32_t, std::uint32_t>(mesh_indices, {-1}, "mesh_indices"),
                        .name_indices = to_vector<std::uint32_t, std::uint32_t>(name_indices, {count}, "name_indices"),
                        .first_slot_materials = to_vector<std::uint32_t, std::uint32_t>(first_slot_materials, {count},
                                                                                        "first_slot_materials"),
                        .slot_counts = to_vector<std::uint16_t, std::uint16_t>(slot_counts, {count}, "slot_counts"),
                        .shows_to = to_vector<std::uint8_t, std::uint8_t>(shows_to, {count}, "shows_to"),
                        .randoms = to_vector<float, float>(randoms, {count}, "randoms"),
                        .world_from_object = world_from_object});
    description.shapes.assign(shapes.begin(), shapes.end());
    const auto names = static_cast<py::ssize_t>(object_names.size());
    const auto colors = to_vector<vec4, float>(object_colors, {names, 4}, "object_colors");
    const auto indices = to_vector<float, float>(object_indices, {names}, "object_indices");
    description.placed_shapes = make_placed_shapes(shape_indices, shape_materials, shape_shows_to, shape_randoms,
                                                   world_from_shape, object_names.size());
    description.object_infos = make_object_infos(object_names.size(), object_light_groups, object_sets, object_links);
    for (std::size_t i = 0; i < colors.size(); ++i) {
        description.object_infos[i].color = colors[i];
        description.object_infos[i].pass_index = indices[i];
    }
    description.object_names = std::move(object_names);
    description.slot_materials = to_vector<std::uint32_t, std::uint32_t>(slot_materials, {-1}, "slot_materials");
    description.materials = std::move(materials);
    description.media = std::move(media);
    description.volumes = std::move(volumes);
    description.world_medium_index = world_medium;
    static_assert(sizeof(ParticleState) == 14 * sizeof(float));
    description.particles = to_vector<ParticleState, float>(particles, {-1, 14}, "particles");
    description.instance_particles =
        to_vector<std::uint32_t, std::uint32_t>(instance_particles, {-1}, "instance_particles");
    description.instancer_values = to_vector<vec4, float>(instancer_values, {-1, -1, 4}, "instancer_values");
    description.instancer_value_count = static_cast<std::uint32_t>(instancer_values.shape(1));
    description.instancer_rows = to_vector<std::uint32_t, std::uint32_t>(instancer_rows, {-1}, "instancer_rows");
    return without_gil([&] { return std::make_unique<SceneWithMedia>(std::move(description), progress); });
}

static std::shared_ptr<Strands> make_strands(std::string name, int form, const py::array& points,
                                             const py::array& first_points, std::uint32_t ribbon_pieces,
                                             std::uint32_t layers,
                                             const std::vector<std::pair<std::string, py::array>>& maps,
                                             const std::optional<py::array>& randoms, const Progress& progress) {
    StrandArrays arrays{.name = std::move(name),
                        .form = static_cast<StrandForm>(form),
                        .points = to_vector<vec4, float>(points, {-1, 4}, "points"),
                        .first_points = to_vector<std::uint32_t, std::uint32_t>(first_points, {-1}, "first_points"),
                        .ribbon_pieces = ribbon_pieces,
                        .layers = layers};
    for (const auto& [map_name, values] : maps)
        arrays.maps.push_back({map_name, to_vector<vec2, float>(values, {-1, 2}, "map " + map_name)});
    if (randoms)
        arrays.randoms = to_vector<float, float>(*randoms, {-1}, "randoms");
    return without_gil([&] { return std::make_shared<Strands>(std::move(arrays), progress); });
}

void bind_scene(py::module_& native) {
    native.def("most_embree_bytes", &most_embree_bytes, "The most memory that Embree has held at one time.");
    py::class_<TriangleMesh, std::shared_ptr<TriangleMesh>>(
        native, "TriangleMesh", "Triangles with their BVH; copies all arrays but a shared_array.")
        .def(py::init(&make_mesh), "name"_a, "positions"_a, "triangles"_a, "material_slots"_a, "corner_normals"_a,
             "uv_maps"_a, "progress"_a, "is_hasty"_a = false,
             R"(positions: float32 (v, 3); triangles: uint32 (t, 3); material_slots: uint16 (t,) or None;
corner_normals: float32 (t, 3, 3) or None; uv_maps: pairs of name and float32 (t, 3, 2). is_hasty: its BVH is there in
0.3 of the time, until finish_tree(). Releases the GIL. TypeError: dtype or shape; InvalidInput: a value; Cancelled.)")
        .def_property_readonly("has_hasty_tree", &TriangleMesh::has_hasty_tree)
        .def(
            "finish_tree",
            [](const TriangleMesh& mesh, const Progress& progress) {
                without_gil([&] { mesh.finish_tree(progress); });
            },
            "progress"_a,
            "The BVH as of a mesh that was not hasty, in all scenes of the mesh: nothing may be rendered meanwhile. "
            "Cancelled: it is as it was. Releases the GIL.")
        .def_property_readonly("triangle_count", &TriangleMesh::triangle_count)
        .def_property_readonly("non_finite_triangle_count", &TriangleMesh::non_finite_triangle_count)
        .def_property_readonly("degenerate_triangle_count", &TriangleMesh::degenerate_triangle_count)
        .def_property_readonly("bounds_m", [](const TriangleMesh& mesh) {
            const Bounds3& box = mesh.bounds();
            return std::array<Triple, 2>{{{box.min.x, box.min.y, box.min.z}, {box.max.x, box.max.y, box.max.z}}};
        });
    py::class_<Light>(native, "Light")
        .def(py::init(&make_light), "name"_a, "kind"_a, "strength"_a, "position"_a, "axis"_a,
             "light_from_world_directions"_a, "half_angle_rad"_a, "radius_m"_a, "spot_half_angle_rad"_a, "spot_blend"_a,
             "spot_falloff"_a, "body"_a, "half_size_m"_a, "is_ellipse"_a, "casts_shadow"_a, "lights_surfaces"_a,
             "lights_catchers"_a, "scatters_in_media"_a, "occluder_edits"_a, "texture"_a,
             "light_group"_a = no_light_group, "links"_a = std::array<std::uint64_t, 2>{~0ull, ~0ull},
             "unlit_media"_a = std::vector<std::array<std::uint16_t, 2>>(),
             "position: relative to the scene's origin; axis: unit vector along which the light shines; light_group: "
             "255 "
             "is none; links: a bit for each set of receivers and of blockers; unlit_media: pairs of a medium in which "
             "it "
             "scatters nothing, and one that only dims as much.");
    py::class_<World>(native, "World")
        .def(py::init(&make_world), "name"_a, "radiance"_a, "pixels"_a, "image_from_world"_a,
             "seen_pixels"_a = py::none(), "seen_program"_a = py::none(), "light_group"_a = no_light_group,
             "lights_surfaces"_a = std::array<bool, 3>{true, true, true}, "scatters_in_media"_a = true,
             "pixels: float32 (height, width, 4), rows bottom to top, or None; image_from_world: float32 (3, 3); "
             "seen_pixels: as pixels, what cameras see instead of them; seen_program: the radiance that they see.");
    py::class_<ShapeGeometry, std::shared_ptr<ShapeGeometry>>(native, "Shape", "What scenes place beside meshes.");
    py::class_<Strands, ShapeGeometry, std::shared_ptr<Strands>>(native, "Strands", "Hair, or points, with their BVH.")
        .def(
            py::init(&make_strands), "name"_a, "form"_a, "points"_a, "first_points"_a, "ribbon_pieces"_a, "layers"_a,
            "maps"_a, "randoms"_a, "progress"_a,
            R"(points: float32 (n, 4), position and radius; first_points: uint32, of each strand; maps: pairs of name and
float32 (strands, 2) or (n, 2); randoms: float32 (strands,) or None. Releases the GIL. TypeError, InvalidInput, Cancelled.)")
        .def_property_readonly("strand_count", &Strands::strand_count)
        .def_property_readonly("segment_count", &Strands::segment_count);
    py::class_<CellGeometry, ShapeGeometry, std::shared_ptr<CellGeometry>>(native, "VoxelShape",
                                                                           "A voxel DAG that scenes can place.")
        .def(py::init([](const std::shared_ptr<voxel_dag::PlacedDag>& dag, std::string name) {
                 return without_gil(
                     [&] { return std::make_shared<CellGeometry>(voxel_dag::make_voxel_shape(dag, std::move(name))); });
             }),
             "dag"_a, "name"_a, "name: for reports. Keeps the DAG, without a copy. Releases the GIL.");
    py::class_<SceneWithMedia>(native, "Scene", "With its media. Immutable; safe from any thread.")
        .def(py::init(&make_scene), "origin_in_world"_a, "meshes"_a, "mesh_indices"_a, "world_from_object"_a,
             "object_names"_a, "name_indices"_a, "first_slot_materials"_a, "slot_counts"_a, "shows_to"_a,
             "slot_materials"_a, "randoms"_a, "object_colors"_a, "object_indices"_a, "object_light_groups"_a,
             "object_sets"_a, "object_links"_a, "shapes"_a, "shape_indices"_a, "world_from_shape"_a,
             "shape_materials"_a, "shape_shows_to"_a, "shape_randoms"_a, "materials"_a, "media"_a, "volumes"_a,
             "world_medium"_a, "particles"_a, "instance_particles"_a, "instancer_values"_a, "instancer_rows"_a,
             "progress"_a,
             R"(In the dark, see relit. Per instance: mesh_indices and first_slot_materials uint32, slot_counts uint16,
shows_to uint8, a bit each for cameras, lights' shadows, bounces, mirrors and glass, and one each for what is
held out, for shadow catchers and for what lights media, world_from_object float32 (n, 4, 4)
relative to origin_in_world. The same per placed shape, of which
shape_materials, uint32, is the one material. object_names: those that name_indices, uint32 per instance, point to, and
then one per shape. Of all of these, object_colors, float32 (n, 4), object_indices, float32, object_light_groups, uint8
(255: none), object_sets, uint8 (n, 2), of receivers and blockers, and object_links, uint64 (n, 2), those they light and
are blocked by. particles: float32 (n, 14), the members of ParticleState; instance_particles, uint32, says which of them
each instance is, or 2^32 - 1; or nothing, if none is one. instancer_values: float32 (n, values, 4), what instancers
give; instancer_rows, uint32, the same way. Releases the GIL.)")
        .def(
            "moved",
            [](const SceneWithMedia& built, const py::array& instances, const py::array& world_from_object,
               bool keeps_tree, const Progress& progress) {
                const auto indices = to_vector<std::uint32_t, std::uint32_t>(instances, {-1}, "instances");
                check_array<float>(world_from_object, {static_cast<py::ssize_t>(indices.size()), 4, 4},
                                   "world_from_object");
                const auto* matrices = static_cast<const float*>(world_from_object.data());
                std::vector<MovedInstance> moved;
                for (const std::uint32_t index : indices)
                    moved.push_back({index, to_matrix<mat4, 4>(matrices + 16 * moved.size())});
                const TreeUpdate update = keeps_tree ? TreeUpdate::Beside : TreeUpdate::Anew;
                return without_gil([&] { return std::make_unique<SceneWithMedia>(built, moved, update, progress); });
            },
            "instances"_a, "world_from_object"_a, "keeps_tree"_a, "progress"_a,
            "The same with some instances elsewhere, relative to its origin. keeps_tree: over those that did not move, "
            "where there are thousands; then of two surfaces in one place another one may answer than in a new scene. "
            "InvalidInput: one cannot stand there; Cancelled. Releases the GIL.")
        .def_property_readonly(
            "instance_count", [](const SceneWithMedia& built) { return built.scene->description().instances.size(); },
            "Of meshes, without those that were left out.")
        .def_property_readonly(
            "has_fog", [](const SceneWithMedia& built) { return !built.media->is_empty(); },
            "Some medium scatters, absorbs or glows.")
        .def(
            "relit",
            [](const SceneWithMedia& built, std::vector<Light> lights, World world) {
                return std::make_unique<SceneWithMedia>(built, std::move(lights), std::move(world));
            },
            "lights"_a, "world"_a, "The same geometry, materials and media under other lights: nothing is built again.")
        .def_property_readonly("statistics", [](const SceneWithMedia& built) { return built.scene->statistics(); });
}
} // namespace tyndall::bindings
