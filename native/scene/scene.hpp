// SPDX-License-Identifier: GPL-3.0-or-later
// An immutable scene: shared meshes, instances, materials, lights, world and media, with one committed Embree BVH.
// Space: all positions are relative to origin_in_world (double), so that a scene 60 km out keeps its millimetres.
#pragma once
#include "core/progress.hpp"
#include "core/statistics.hpp"
#include "scene/camera.hpp"
#include "scene/light.hpp"
#include "scene/triangle_mesh.hpp"
#include "scene/world.hpp"
#include "shading/material.hpp"
#include "volume/medium.hpp"
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace tyndall {
struct Instance {
    std::uint32_t mesh_index = 0;
    mat4 world_from_object{1.0f}; ///< Affine; may mirror. In the scene's space (relative to its origin).
    std::uint32_t name_index = 0; ///< Into SceneDescription::object_names.
    /// First entry in SceneDescription::slot_materials: slot s of the mesh has material slot_materials[first + s].
    std::uint32_t first_slot_material = 0;
    std::uint16_t slot_count = 1;
    bool is_camera_visible = true;
    bool casts_shadow = true;
};

struct SceneDescription {
    dvec3 origin_in_world{0.0};
    std::vector<std::shared_ptr<const TriangleMesh>> meshes;
    std::vector<Instance> instances;
    std::vector<std::string> object_names;
    std::vector<std::uint32_t> slot_materials; ///< Into materials.
    std::vector<Material> materials;
    std::vector<Medium> media;
    std::vector<Light> lights;
    World world;
    std::int32_t world_medium_index = -1; ///< Into media: fills all space; -1: none.
};

struct Hit {
    float distance_m = 0.0f;
    std::uint32_t instance = ~0u, triangle = ~0u; ///< Of the instance's mesh.
    vec2 barycentrics{0.0f};
    vec3 geometric_normal{0, 0, 1}; ///< Unit, scene space, as the triangle is wound (mirroring undone).
    [[nodiscard]] bool is_hit() const { return instance != ~0u; }
};

class Scene {
public:
    /// Checks indices, drops instances that cannot be drawn (non-finite or singular transform, empty mesh) with a
    /// report each, commits Embree. Throws InvalidInput and Cancelled.
    Scene(SceneDescription description, const Progress& progress);
    Scene(const Scene&) = delete;
    Scene& operator=(const Scene&) = delete;
    ~Scene();

    [[nodiscard]] const SceneDescription& description() const { return description_; }
    [[nodiscard]] std::span<const Light> lights() const { return description_.lights; }
    [[nodiscard]] const World& world() const { return description_.world; }
    [[nodiscard]] const Bounds3& bounds() const { return bounds_; }                 ///< Of all kept instances.
    [[nodiscard]] const Bounds3& surface_bounds() const { return surface_bounds_; } ///< Of those with a surface.
    [[nodiscard]] const Statistics& statistics() const { return statistics_; }
    [[nodiscard]] RTCScene embree_scene() const { return embree_scene_; } ///< Instance i has geometry id i.

    /// Material of a hit triangle.
    [[nodiscard]] const Material& material(std::uint32_t instance, std::uint32_t triangle) const;
    /// Everything a surface program reads at a hit.
    [[nodiscard]] ShadingPoint shading_point(const Ray& ray, const Hit& hit) const;
    [[nodiscard]] SurfaceClosures closures(const Ray& ray, const Hit& hit) const;

    /// Nearest camera-visible surface. Instances without a surface shader (fog boxes) never answer.
    [[nodiscard]] Hit closest_hit(const Ray& ray) const;
    /// Light that passes along the ray through transparent surfaces, per channel; 0 behind an opaque one. Media are
    /// not included. Only instances that cast shadows count.
    [[nodiscard]] Rgb shadow_transmittance(const Ray& ray) const;

private:
    SceneDescription description_;
    Bounds3 bounds_, surface_bounds_;
    Statistics statistics_;
    RTCScene embree_scene_ = nullptr;
};
} // namespace tyndall
