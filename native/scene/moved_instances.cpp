// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/moved_instances.hpp"
#include "shading/op_surroundings.hpp"
#include <algorithm>
#include <cmath>
#include <tuple>

namespace tyndall {
/// A swarm is everywhere.
static constexpr std::size_t most_moved = 4096;
/// Of coordinates: some hundred times what Embree's boxes, transforms and tests round.
static constexpr float relative_margin = 1e-5f;

// Structured bindings name all members: a new one does not compile before it is compared, too.
static bool are_same(const Material& a, const Material& b) {
    const auto all = [](const Material& material) {
        const auto& [name, program, diffuse_register, transparent_register, emission_register, held_out_register,
                     constant, textures, uv_map_names, tables, gloss, lobe_sources, medium_index, has_surface] =
            material;
        const auto& [diffuse_albedo, transparent, emission, mirrored, translucent, held_out] = constant;
        return std::tie(name, program, diffuse_register, transparent_register, emission_register, held_out_register,
                        diffuse_albedo, transparent, emission, mirrored, translucent, held_out, textures, uv_map_names,
                        tables, gloss, lobe_sources, medium_index, has_surface);
    };
    return all(a) == all(b);
}
static bool are_same(const Medium& a, const Medium& b) {
    const auto all = [](const Medium& medium) {
        const auto& [name, lobes, sigma_a_per_m, emission_w_per_m3_sr, receiver_set] = medium;
        return std::tie(name, sigma_a_per_m, emission_w_per_m3_sr, receiver_set);
    };
    const auto of_lobe = [](const ScatterLobe& lobe) {
        const auto& [sigma_s_per_m, asymmetry_g, draine_alpha] = lobe;
        return std::tie(sigma_s_per_m, asymmetry_g, draine_alpha);
    };
    return all(a) == all(b) &&
           std::ranges::equal(a.lobes, b.lobes, [&](const ScatterLobe& lobe, const ScatterLobe& other) {
               return of_lobe(lobe) == of_lobe(other);
           });
}
static bool are_same(const VolumeInstance& a, const VolumeInstance& b) {
    const auto all = [](const VolumeInstance& volume) {
        const auto& [name, grid, channel, medium_index, world_from_local, density_scale] = volume;
        return std::tie(name, grid, channel, medium_index, world_from_local, density_scale);
    };
    return all(a) == all(b);
}
/// But for where they stand.
static bool are_alike(const Instance& a, const Instance& b) {
    const auto all = [](const Instance& instance) {
        const auto& [mesh_index, world_from_object, name_index, first_slot_material, slot_count, is_camera_visible,
                     casts_shadow, is_bounce_visible, is_mirror_visible, is_glass_visible, lights_media, is_held_out,
                     is_shadow_catcher, random] = instance;
        return std::tuple(mesh_index, name_index, first_slot_material, slot_count, is_camera_visible, casts_shadow,
                          is_bounce_visible, is_mirror_visible, is_glass_visible, lights_media, is_held_out,
                          is_shadow_catcher, random);
    };
    return all(a) == all(b);
}
/// But for where instances stand.
static bool are_alike(const SceneDescription& a, const SceneDescription& b) {
    const auto all = [](const SceneDescription& scene) {
        const auto& [origin_in_world, meshes, instances, shapes, placed_shapes, object_names, object_infos,
                     slot_materials, materials, media, volumes, lights, world, world_medium_index, particles,
                     instance_particles, instancer_values, instancer_value_count, instancer_rows] = scene;
        return std::tie(origin_in_world, meshes, shapes, placed_shapes, object_names, object_infos, slot_materials,
                        world_medium_index, particles, instance_particles, instancer_values, instancer_value_count,
                        instancer_rows);
    };
    constexpr auto same = [](const auto& part, const auto& other) { return are_same(part, other); };
    constexpr auto alike = [](const Instance& instance, const Instance& other) { return are_alike(instance, other); };
    return all(a) == all(b) && std::ranges::equal(a.materials, b.materials, same) &&
           std::ranges::equal(a.media, b.media, same) && std::ranges::equal(a.volumes, b.volumes, same) &&
           std::ranges::equal(a.instances, b.instances, alike);
}

static bool bounds_a_medium(const SceneDescription& scene, const Instance& instance) {
    const auto slots = std::span(scene.slot_materials).subspan(instance.first_slot_material, instance.slot_count);
    return std::ranges::any_of(slots,
                               [&](std::uint32_t material) { return scene.materials[material].medium_index >= 0; });
}

std::optional<StoodAt> moved_instances(const SceneDescription& before, const SceneDescription& after) {
    if (!are_alike(before, after))
        return std::nullopt;
    StoodAt stood_at;
    for (std::uint32_t index = 0; index < after.instances.size(); ++index) {
        const mat4& place = before.instances[index].world_from_object;
        if (place == after.instances[index].world_from_object)
            continue;
        if (bounds_a_medium(after, after.instances[index]) || stood_at.size() == most_moved)
            return std::nullopt;
        stood_at[index].push_back(place);
    }
    if (!stood_at.empty() && std::ranges::any_of(after.materials, asks_for_others))
        return std::nullopt;
    return stood_at;
}

/// With a margin for what rounds where the mesh lies far from its object's origin.
static Bounds3 box_of(const Bounds3& of_mesh, const mat4& scene_from_object) {
    Bounds3 box;
    float largest_m = 0.0f;
    for (std::size_t corner = 0; corner < 8 && !of_mesh.is_empty(); ++corner) {
        const vec3 in_object = of_mesh.corner(corner);
        box.grow(vec3(glm::dmat4(scene_from_object) * glm::dvec4(in_object, 1.0)));
        for (int row = 0; row < 3; ++row) {
            float sum_m = std::abs(scene_from_object[3][row]);
            for (int column = 0; column < 3; ++column)
                sum_m += std::abs(scene_from_object[column][row] * in_object[column]);
            largest_m = std::max(largest_m, sum_m);
        }
    }
    box.min -= relative_margin * largest_m;
    box.max += relative_margin * largest_m;
    return box;
}

MovedBoxes::MovedBoxes(const Scene& scene, const StoodAt& stood_at, const vec3& camera_position) {
    for (const auto& [index, places] : stood_at) {
        const Instance& instance = scene.description().instances[index];
        const Bounds3& of_mesh = scene.description().meshes[instance.mesh_index]->bounds();
        const std::size_t first = boxes_.size();
        for (const mat4& place : places)
            if (place != instance.world_from_object)
                boxes_.push_back(box_of(of_mesh, place));
        if (boxes_.size() > first)
            boxes_.push_back(box_of(of_mesh, instance.world_from_object));
    }
    // Instances of one object follow each other, and so do the places of an instance: neighbours are close.
    while (boxes_.size() > most_boxes) {
        for (std::size_t index = 0; index < boxes_.size(); index += 2) {
            boxes_[index / 2] = boxes_[index];
            if (index + 1 < boxes_.size())
                boxes_[index / 2].grow(boxes_[index + 1]);
        }
        boxes_.resize((boxes_.size() + 1) / 2);
    }
    Bounds3 rays_start = scene.surface_bounds();
    rays_start.grow(camera_position);
    const vec3 farthest = glm::max(glm::abs(rays_start.min), glm::abs(rays_start.max));
    const float margin_m = relative_margin * std::max({farthest.x, farthest.y, farthest.z});
    for (Bounds3& box : boxes_) {
        box.min -= margin_m;
        box.max += margin_m;
        around_.grow(box);
    }
}

/// `per_direction`: 1 / the ray's direction, infinite along an axis that it does not follow.
static bool may_meet_box(const Bounds3& box, const Ray& ray, const vec3& per_direction) {
    float near_m = ray.near_m, far_m = ray.far_m;
    for (int axis = 0; axis < 3; ++axis) {
        const float to_min = (box.min[axis] - ray.origin[axis]) * per_direction[axis];
        const float to_max = (box.max[axis] - ray.origin[axis]) * per_direction[axis];
        // 0 times infinity, of a ray in a face's plane, is a NaN: std::max and std::min then keep their first argument.
        near_m = std::max(near_m, std::min(to_min, to_max) * (1.0f - relative_margin));
        far_m = std::min(far_m, std::max(to_min, to_max) * (1.0f + relative_margin));
    }
    return near_m <= far_m;
}

bool MovedBoxes::may_meet(const Ray& ray) const {
    const vec3 per_direction = 1.0f / ray.direction;
    return may_meet_box(around_, ray, per_direction) &&
           (boxes_.size() == 1 ||
            std::ranges::any_of(boxes_, [&](const Bounds3& box) { return may_meet_box(box, ray, per_direction); }));
}
} // namespace tyndall
