// SPDX-License-Identifier: GPL-3.0-or-later
// What a scene is made of and how it comes to stand in Embree; scene_queries.cpp asks it.
#include "scene/scene.hpp"
#include "core/errors.hpp"
#include "scene/embree.hpp"
#include "scene/instance_masks.hpp"
#include "scene/instance_places.hpp"
#include "scene/strands.hpp"
#include "shading/op_inputs.hpp"
#include "shading/surface_program.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <sstream>

namespace tyndall {
Scene::Scene(SceneDescription description, const Progress& progress)
    : lights_(std::move(description.lights)), world_(std::move(description.world)) {
    description.lights.clear();
    description.world = {};
    const StageTimer timer(statistics_, "scene");
    progress.poll();
    const auto geometry = std::make_shared<Geometry>(std::move(description), progress);
    geometry_ = geometry;
    geometry->narrow_strands(*this, progress);
    statistics_.append(geometry_->statistics);
    drop_unusable_lights();
}

Scene::Scene(const Scene& other, std::vector<Light> lights, World world)
    : lights_(std::move(lights)), world_(std::move(world)), geometry_(other.geometry_),
      statistics_(geometry_->statistics) {
    drop_unusable_lights();
}

Scene::~Scene() = default;
Scene::Geometry::~Geometry() = default;

/// Whether what it lets pass differs between kinds of rays that gather light.
static bool tells_light_apart(const Material& material, const TransparentOperations& operations) {
    constexpr auto bit = [](RayKind kind) { return 1u << static_cast<unsigned int>(kind); };
    constexpr unsigned int of_light = bit(RayKind::Shadow) | bit(RayKind::Diffuse) | bit(RayKind::Glossy);
    return std::ranges::any_of(operations.places, [&](std::uint16_t place) {
        const SurfaceOp& op = material.program[place];
        const unsigned int asked = op.selector & of_light;
        return reads(op, PointInput::IsRay) && asked != 0 && asked != of_light;
    });
}

/// Whether what it lets pass differs with what did so before.
static bool counts_passed_surfaces(const Material& material, const TransparentOperations& operations) {
    return std::ranges::any_of(operations.places, [&](std::uint16_t place) {
        return reads(material.program[place], PointInput::PassedCount);
    });
}

Scene::Geometry::Geometry(SceneDescription scene, const Progress& progress) : description(std::move(scene)) {
    validate();
    for (const Material& material : description.materials) {
        transparent_operations.emplace_back(material);
        tells_rays_apart |= tells_light_apart(material, transparent_operations.back());
        if (!counts_passed_surfaces(material, transparent_operations.back()))
            continue;
        counts_passed = true;
        if (!description.media.empty() || !description.volumes.empty())
            statistics.report("Material \"" + material.name +
                              "\": Transparent Depth is 0 where it shades light shafts");
    }
    drop_unusable_instances();
    drop_unusable_volumes();
    set_blocker_bits();
    attach_instances(progress);
}

void Scene::Geometry::set_blocker_bits() {
    if (std::ranges::all_of(description.object_infos, [](const ObjectInfo& info) { return info.blocker_set == 0; }))
        return;
    const auto add = [&](std::uint32_t name_index) {
        blocker_bits.push_back(std::uint64_t{1} << description.object_infos[name_index].blocker_set);
    };
    for (const Instance& instance : description.instances)
        add(instance.name_index);
    for (const PlacedShape& placed : description.placed_shapes)
        add(placed.name_index);
}

void Scene::Geometry::validate() const {
    const SceneDescription& scene = description;
    for (const Instance& instance : scene.instances) {
        require(instance.name_index < scene.object_names.size(), "an instance asks for object name ",
                instance.name_index, " of ", scene.object_names.size());
        const std::string& name = scene.object_names[instance.name_index];
        require(instance.mesh_index < scene.meshes.size() && scene.meshes[instance.mesh_index] != nullptr, "object '",
                name, "' asks for mesh ", instance.mesh_index, " of ", scene.meshes.size());
        require(instance.slot_count > 0, "object '", name, "' has no material slot");
        require(std::size_t{instance.first_slot_material} + instance.slot_count <= scene.slot_materials.size(),
                "object '", name, "' asks for slot material ", instance.first_slot_material + instance.slot_count - 1u,
                " of ", scene.slot_materials.size());
    }
    for (const PlacedShape& placed : scene.placed_shapes) {
        require(placed.name_index < scene.object_names.size(), "a shape asks for object name ", placed.name_index,
                " of ", scene.object_names.size());
        const std::string& name = scene.object_names[placed.name_index];
        require(placed.shape_index < scene.shapes.size() && scene.shapes[placed.shape_index] != nullptr, "object '",
                name, "' asks for shape ", placed.shape_index, " of ", scene.shapes.size());
        require(placed.material_index < scene.materials.size(), "object '", name, "' asks for material ",
                placed.material_index, " of ", scene.materials.size());
    }
    require(scene.object_infos.empty() || scene.object_infos.size() == scene.object_names.size(), "there are ",
            scene.object_infos.size(), " object infos for ", scene.object_names.size(), " object names");
    for (std::size_t index = 0; index < scene.object_infos.size(); ++index)
        require(std::max(scene.object_infos[index].receiver_set, scene.object_infos[index].blocker_set) <
                    LightLinks::most_sets,
                "object '", scene.object_names[index], "' is in a set of light linking beyond ",
                LightLinks::most_sets - 1);
    require(scene.instance_particles.empty() || scene.instance_particles.size() == scene.instances.size(), "there are ",
            scene.instance_particles.size(), " particle indices for ", scene.instances.size(), " instances");
    for (const std::uint32_t particle : scene.instance_particles)
        require(particle == SceneDescription::no_particle || particle < scene.particles.size(),
                "an instance asks for particle ", particle, " of ", scene.particles.size());
    require(scene.instancer_rows.empty() || scene.instancer_rows.size() == scene.instances.size(), "there are ",
            scene.instancer_rows.size(), " rows of instancers' values for ", scene.instances.size(), " instances");
    for (const std::uint32_t row : scene.instancer_rows)
        require(row == SceneDescription::no_row ||
                    (std::size_t{row} + 1) * scene.instancer_value_count <= scene.instancer_values.size(),
                "an instance asks for row ", row, " of ", scene.instancer_values.size(), " values of instancers, ",
                scene.instancer_value_count, " a row");
    for (const std::uint32_t material : scene.slot_materials)
        require(material < scene.materials.size(), "a slot asks for material ", material, " of ",
                scene.materials.size());
    const auto medium_count = static_cast<std::int32_t>(scene.media.size());
    for (const Material& material : scene.materials) {
        tyndall::validate(material);
        require(material.medium_index >= -1 && material.medium_index < medium_count, "material '", material.name,
                "' asks for medium ", material.medium_index, " of ", medium_count);
    }
    for (const VolumeInstance& volume : scene.volumes)
        require(volume.grid != nullptr && volume.medium_index < scene.media.size() &&
                    volume.channel < volume.grid->channel_count(),
                "volume '", volume.name, "' asks for medium ", volume.medium_index, " of ", scene.media.size(),
                " and channel ", volume.channel, " of its grid");
    require(scene.world_medium_index >= -1 && scene.world_medium_index < medium_count, "the world asks for medium ",
            scene.world_medium_index, " of ", medium_count);
}

static const char* why_empty(const ShapeGeometry& shape) {
    return shape.cells() != nullptr ? "it has no voxel" : "it has no usable strand or point";
}

void Scene::Geometry::report_unusable_strands(const Strands& strands) {
    const bool has_strands = strands.form() != StrandForm::Spheres;
    std::string what;
    for (const auto& [count, kind] :
         {std::pair{strands.non_finite_count(), "a position or radius that is not finite"},
          {strands.degenerate_count(), has_strands ? "no length or no width" : "no radius"}})
        if (count > 0)
            what += (what.empty() ? "" : " and ") + std::to_string(count) +
                    (has_strands ? (count == 1 ? " strand with " : " strands with ")
                                 : (count == 1 ? " point with " : " points with ")) +
                    kind;
    if (!what.empty())
        statistics.report((has_strands ? "strands '" : "points '") + strands.name() + "': left out " + what);
}

void Scene::Geometry::drop_unusable_instances() {
    std::map<std::pair<std::uint32_t, std::string>, std::size_t> dropped_counts; // an object's particles share a line
    const auto is_dropped = [&](auto& instance, bool is_empty, const char* why_empty) {
        instance.world_from_object = thickened(instance.world_from_object);
        const char* reason = is_empty ? why_empty : reason_to_drop(instance.world_from_object);
        if (reason != nullptr)
            ++dropped_counts[{instance.name_index, reason}];
        return reason != nullptr;
    };
    const std::array of_instances{&description.instance_particles, &description.instancer_rows};
    std::size_t index = 0, kept = 0;
    std::erase_if(description.instances, [&](Instance& instance) {
        const bool is_empty = description.meshes[instance.mesh_index]->triangle_count() == 0;
        const bool drops = is_dropped(instance, is_empty, "its mesh has no usable triangle");
        if (!drops) {
            for (std::vector<std::uint32_t>* const indices : of_instances)
                if (!indices->empty())
                    (*indices)[kept] = (*indices)[index];
            ++kept;
        }
        ++index;
        return drops;
    });
    for (std::vector<std::uint32_t>* const indices : of_instances)
        if (!indices->empty())
            indices->resize(kept);
    std::erase_if(description.placed_shapes, [&](PlacedShape& placed) {
        const ShapeGeometry& shape = *description.shapes[placed.shape_index];
        return is_dropped(placed, shape.bounds().is_empty(), why_empty(shape));
    });
    for (const auto& [object_and_reason, count] : dropped_counts) {
        const auto& [name_index, reason] = object_and_reason;
        statistics.report("object '" + description.object_names[name_index] + "'" +
                          (count > 1 ? ", " + std::to_string(count) + " instances," : "") + " left out: " + reason);
    }
    for (const auto& mesh : description.meshes) {
        if (mesh == nullptr)
            continue;
        std::string what;
        // What has no area covers nothing: models have some, and nobody misses them unless they are most of one.
        const std::size_t flat = mesh->degenerate_triangle_count(), of_any_use = mesh->triangle_count();
        for (const auto& [count, kind] : {std::pair{mesh->non_finite_triangle_count(), "a vertex that is not finite"},
                                          {flat >= of_any_use ? flat : std::size_t{0}, "no area"}})
            if (count > 0)
                what += (what.empty() ? "" : " and ") + std::to_string(count) +
                        (count == 1 ? " triangle with " : " triangles with ") + kind;
        if (!what.empty())
            statistics.report("mesh '" + mesh->arrays().name + "': left out " + what);
    }
    for (const auto& shape : description.shapes)
        if (const Strands* strands = shape ? shape->strands() : nullptr)
            report_unusable_strands(*strands);
}

/// A broken parent's matrix, or a driver that divides by 0, reaches a light's numbers; one NaN would blacken the frame.
static bool is_usable(const Light& light) {
    const auto is_finite = [](const vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); };
    const auto is_unit = [](const vec3& v) { return std::abs(glm::dot(v, v) - 1.0f) < 1e-3f; };
    bool is_sound = is_finite(light.strength) && is_finite(light.position) && light.radius_m >= 0.0f &&
                    std::isfinite(light.radius_m) && std::isfinite(light.half_angle_rad);
    if (light.kind == LightKind::Sun)
        is_sound = is_sound && is_unit(light.towards_light);
    if (light.kind == LightKind::Spot || light.kind == LightKind::Area)
        is_sound = is_sound && is_unit(light.spot_axis) &&
                   std::isfinite(light.spot_half_angle_rad + light.spot_blend) &&
                   is_finite(light.light_from_world_directions * light.spot_axis);
    if (light.kind == LightKind::Area)
        is_sound = is_sound && light.half_size_m.x > 0.0f && light.half_size_m.y > 0.0f &&
                   std::isfinite(light.half_size_m.x + light.half_size_m.y);
    return is_sound;
}

void Scene::Geometry::drop_unusable_volumes() {
    std::erase_if(description.volumes, [&](const VolumeInstance& volume) {
        const char* reason = nullptr;
        if (!is_finite(volume.world_from_local) || !(volume.density_scale >= 0.0f && volume.density_scale <= 1e9f))
            reason = "its transform is not finite";
        else if (!is_regular(volume.world_from_local))
            reason = "its transform leaves it no volume (scales of 0)";
        else if (volume.grid->is_empty())
            reason = "its grid has no density";
        if (reason != nullptr)
            statistics.report("volume '" + volume.name + "' left out: " + reason);
        return reason != nullptr;
    });
}

void Scene::drop_unusable_lights() {
    const std::size_t medium_count = description().media.size();
    for (const Light& light : lights_)
        for (const auto& [medium, dark] : light.unlit_media)
            require(std::max(medium, dark) < medium_count, "light '", light.name, "' asks for medium ",
                    std::max(medium, dark), " of ", medium_count);
    std::erase_if(lights_, [&](const Light& light) {
        if (is_usable(light))
            return false;
        statistics_.report("light '" + light.name + "' left out: its strength, size or transform is not finite");
        return true;
    });
}

const Material& Scene::Geometry::slot_material(const Instance& instance, std::size_t slot) const {
    // A triangle whose slot the object lacks takes the last one, as in Blender.
    const std::size_t present = std::min<std::size_t>(slot, instance.slot_count - 1u);
    return description.materials[description.slot_materials[instance.first_slot_material + present]];
}

Bounds3 transformed(const Bounds3& bounds, const mat4& to_from) {
    Bounds3 result;
    for (std::size_t corner = 0; corner < 8 && !bounds.is_empty(); ++corner)
        result.grow(vec3(to_from * vec4(bounds.corner(corner), 1.0f)));
    return result;
}

mat3 Scene::normal_matrix(const mat4& object_from_scene) {
    float largest = 0.0f;
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row)
            largest = std::max(largest, std::abs(object_from_scene[column][row]));
    return glm::transpose(mat3(object_from_scene)) * (1.0f / largest);
}

void Scene::prepare_detail(const Progress& progress) const {
    for (const auto& shape : description().shapes)
        if (const CellShape* cells = shape->cells())
            cells->prepare_detail(progress);
}

void Scene::Geometry::attach_instances(const Progress& progress) {
    objects_from_scene.resize(description.instances.size() + description.placed_shapes.size());
    shape_lengths.resize(description.placed_shapes.size());
    for (std::uint32_t index = 0; index < description.instances.size(); ++index) {
        const Instance& instance = description.instances[index];
        const TriangleMesh& mesh = *description.meshes[instance.mesh_index];
        const Bounds3 box = transformed(mesh.bounds(), instance.world_from_object);
        has_catchers |= instance.is_shadow_catcher;
        bounds.grow(box);
        objects_from_scene[index] = inverse_of(instance.world_from_object);
        limit_reach(index, instance.name_index);

        std::size_t surface_slots = 0, opaque_slots = 0;
        for (std::size_t slot = 0; slot < instance.slot_count; ++slot) {
            const Material& material = slot_material(instance, slot);
            surface_slots += material.has_surface;
            opaque_slots += material.has_surface && is_opaque_everywhere(material);
        }
        if (surface_slots == 0)
            continue; // light and view pass: the media have an Embree scene of their own
        surface_bounds.grow(box);
        const unsigned int mask = mask_of(instance);
        has_holes |=
            (mask & (camera_mask | bounce_mask | mirror_mask | glass_mask)) != 0 && surface_slots < instance.slot_count;
        lets_light_pass |=
            (mask & (shadow_mask | bounce_mask | mirror_mask)) != 0 && opaque_slots < instance.slot_count;

        tells_rays_apart |= tyndall::tells_rays_apart(mask);
        trees.take(mesh.embree_scene(), instance.world_from_object, index, mask);
    }
    for (std::size_t i = 0; i < description.placed_shapes.size(); ++i) {
        const PlacedShape& placed = description.placed_shapes[i];
        const ShapeGeometry& shape = *description.shapes[placed.shape_index];
        const std::size_t index = description.instances.size() + i;
        const Bounds3 box = bounds_of(description, placed);
        has_catchers |= placed.is_shadow_catcher;
        bounds.grow(box);
        objects_from_scene[index] = inverse_of(placed.world_from_object);
        limit_reach(index, placed.name_index);
        float longest_edge = 0.0f; // of a cube of 1 m there
        for (int axis = 0; axis < 3; ++axis)
            longest_edge = std::max(longest_edge, glm::length(vec3(placed.world_from_object[axis])));
        shape_lengths[i] = 1.0f / longest_edge;
        if (!stops_light(description, placed))
            continue;
        surface_bounds.grow(box);
        const unsigned int mask = mask_of(placed);
        if (!is_opaque_everywhere(description.materials[placed.material_index])) {
            if (shape.cells() != nullptr)
                statistics.report("object '" + description.object_names[placed.name_index] +
                                  "': its material lets a part of the light pass, but voxels are opaque");
            else
                lets_light_pass = true;
        }
        tells_rays_apart |= tyndall::tells_rays_apart(mask);
        trees.take(shape.embree_scene(), placed.world_from_object, static_cast<std::uint32_t>(index), mask);
    }
    report_reach();
    trees.commit(progress);
}

void Scene::Geometry::limit_reach(std::size_t instance, std::uint32_t name_index) {
    const float reach = tyndall::reach_m(objects_from_scene[instance]);
    if (reach >= reach_m)
        return;
    reach_m = reach;
    name_of_least_reach = name_index;
}

void Scene::Geometry::report_reach() {
    if (bounds.is_empty() || (is_within(bounds.min, reach_m) && is_within(bounds.max, reach_m)))
        return;
    std::ostringstream report;
    report << "object '" << description.object_names[name_of_least_reach] << "' is so thin or small that rays from "
           << "more than " << reach_m << " m away meet nothing, yet something is there: enlarge it, or bring near what "
           << "lies farthest";
    statistics.report(report.str());
}
} // namespace tyndall
