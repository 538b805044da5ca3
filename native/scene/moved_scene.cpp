// SPDX-License-Identifier: GPL-3.0-or-later
// A scene of which some instances stand elsewhere, made of what it was.
#include "core/errors.hpp"
#include "scene/instance_masks.hpp"
#include "scene/instance_places.hpp"
#include "scene/scene.hpp"
#include "shading/surface_program.hpp"

namespace tyndall {
Scene::Scene(const Scene& other, std::span<const MovedInstance> moved, TreeUpdate update, const Progress& progress)
    : lights_(other.lights_), world_(other.world_) {
    const StageTimer timer(statistics_, "scene");
    for (const MovedInstance& instance : moved) {
        require(instance.index < other.description().instances.size(), "instance ", instance.index, " of ",
                other.description().instances.size(), " is to move");
        const char* reason = cannot_move(instance);
        require(reason == nullptr, "instance ", instance.index, " is to move, but ", reason);
    }
    geometry_ = std::make_shared<const Geometry>(*other.geometry_, moved, update, progress);
    statistics_.append(geometry_->statistics);
}

const char* Scene::cannot_move(const MovedInstance& moved) {
    return reason_to_drop(thickened(moved.world_from_object));
}

/// Whether a part of a box that is taken away may be all that reaches so far.
static bool may_bound(const Bounds3& part, const Bounds3& all) {
    for (int axis = 0; axis < 3; ++axis)
        if (part.min[axis] <= all.min[axis] || part.max[axis] >= all.max[axis])
            return true;
    return false;
}

void Scene::Geometry::find_bounds() {
    bounds = surface_bounds = {};
    for (const Instance& instance : description.instances) {
        const Bounds3 box = transformed(description.meshes[instance.mesh_index]->bounds(), instance.world_from_object);
        bounds.grow(box);
        if (description.has_surface(instance))
            surface_bounds.grow(box);
    }
    for (const PlacedShape& placed : description.placed_shapes) {
        const Bounds3 box = bounds_of(description, placed);
        bounds.grow(box);
        if (stops_light(description, placed))
            surface_bounds.grow(box);
    }
}

Scene::Geometry::Geometry(const Geometry& other, std::span<const MovedInstance> moved, TreeUpdate update,
                          const Progress& progress)
    : description(other.description), bounds(other.bounds), surface_bounds(other.surface_bounds),
      objects_from_scene(other.objects_from_scene), reach_m(other.reach_m),
      name_of_least_reach(other.name_of_least_reach), shape_lengths(other.shape_lengths),
      transparent_operations(other.transparent_operations), lets_light_pass(other.lets_light_pass),
      blocker_bits(other.blocker_bits), has_holes(other.has_holes), has_catchers(other.has_catchers),
      tells_rays_apart(other.tells_rays_apart), counts_passed(other.counts_passed) {
    statistics.reports = other.statistics.reports;
    bool may_shrink = false;
    std::vector<std::uint32_t> indices;
    for (const auto& [index, world_from_object] : moved) {
        Instance& instance = description.instances[index];
        const Bounds3& of_mesh = description.meshes[instance.mesh_index]->bounds();
        may_shrink |= may_bound(transformed(of_mesh, instance.world_from_object), bounds) ||
                      may_bound(transformed(of_mesh, instance.world_from_object), surface_bounds);
        instance.world_from_object = thickened(world_from_object);
        objects_from_scene[index] = inverse_of(instance.world_from_object);
        limit_reach(index, instance.name_index);
        const Bounds3 box = transformed(of_mesh, instance.world_from_object);
        bounds.grow(box);
        if (description.has_surface(instance))
            surface_bounds.grow(box);
        indices.push_back(index);
    }
    if (may_shrink)
        find_bounds();
    const StageTimer timer(statistics, "scene: tree");
    if (update == TreeUpdate::Beside && other.trees.can_move(description.instances.size(), indices)) {
        trees = InstanceTrees(other.trees, indices);
        for (const std::uint32_t index : trees.moved())
            take(index);
    } else {
        share_trees(other, indices);
    }
    trees.commit(progress);
}

void Scene::Geometry::take(std::uint32_t index) {
    const Instance& instance = description.instances[index];
    if (description.has_surface(instance))
        trees.take(description.meshes[instance.mesh_index]->embree_scene(), instance.world_from_object, index,
                   mask_of(instance));
}

void Scene::Geometry::share_trees(const Geometry& other, std::span<const std::uint32_t> but) {
    std::vector<bool> is_moved(description.instances.size());
    for (const std::uint32_t index : but)
        is_moved[index] = true;
    for (std::uint32_t index = 0; index < description.instances.size(); ++index) {
        if (is_moved[index])
            take(index);
        else if (description.has_surface(description.instances[index]))
            trees.share(other.trees, index);
    }
    for (std::size_t i = 0; i < description.placed_shapes.size(); ++i)
        if (stops_light(description, description.placed_shapes[i]))
            trees.share(other.trees, static_cast<std::uint32_t>(description.instances.size() + i));
}
} // namespace tyndall
