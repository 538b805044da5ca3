// SPDX-License-Identifier: GPL-3.0-or-later
// Small scenes for tests: parts of one mesh, one material and one transform each.
#pragma once
#include "scene/scene.hpp"
#include <memory>
#include <vector>

namespace tyndall::support {
inline std::shared_ptr<const TriangleMesh> mesh_of(MeshArrays arrays) {
    return std::make_shared<const TriangleMesh>(std::move(arrays), Progress());
}
/// A copy that can be changed.
inline MeshArrays arrays_of(const TriangleMesh& mesh) {
    const SharedMeshArrays& shared = mesh.arrays();
    MeshArrays arrays{.name = shared.name,
                      .positions = {shared.positions.begin(), shared.positions.end()},
                      .triangles = {shared.triangles.begin(), shared.triangles.end()},
                      .material_slots = {shared.material_slots.begin(), shared.material_slots.end()},
                      .corner_normals = {shared.corner_normals.begin(), shared.corner_normals.end()}};
    for (const SharedMeshArrays::UvMap& map : shared.uv_maps)
        arrays.uv_maps.push_back({map.name, {map.corner_uvs.begin(), map.corner_uvs.end()}});
    return arrays;
}
/// The square [-1, 1]^2 in the plane z = 0, facing +Z.
inline std::shared_ptr<const TriangleMesh> square() {
    return mesh_of({.name = "square",
                    .positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}},
                    .triangles = {{0, 1, 2}, {0, 2, 3}},
                    .uv_maps = {{.name = "UVMap", .corner_uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}}}}});
}
/// The cube [-1, 1]^3, facing outwards.
inline std::shared_ptr<const TriangleMesh> cube() {
    MeshArrays arrays;
    arrays.name = "cube";
    for (int corner = 0; corner < 8; ++corner)
        arrays.positions.emplace_back(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    for (const auto [a, b, c, d] : {glm::uvec4(0, 4, 6, 2), glm::uvec4(1, 3, 7, 5), glm::uvec4(0, 1, 5, 4),
                                    glm::uvec4(2, 6, 7, 3), glm::uvec4(0, 2, 3, 1), glm::uvec4(4, 5, 7, 6)}) {
        arrays.triangles.emplace_back(a, b, c);
        arrays.triangles.emplace_back(a, c, d);
    }
    return mesh_of(std::move(arrays));
}
inline mat4 translation(vec3 offset) { return glm::translate(mat4(1.0f), offset); }

struct Part {
    std::shared_ptr<const TriangleMesh> mesh;
    mat4 world_from_object{1.0f};
    Material material{.name = "white"};
    bool is_camera_visible = true, casts_shadow = true;
};
/// Part i is instance i, named "part <i>".
inline std::unique_ptr<Scene> make_scene(const std::vector<Part>& parts, std::vector<Medium> media = {},
                                         std::vector<Light> lights = {}) {
    SceneDescription description;
    for (std::uint32_t index = 0; index < parts.size(); ++index) {
        description.meshes.push_back(parts[index].mesh);
        description.materials.push_back(parts[index].material);
        description.slot_materials.push_back(index);
        description.object_names.push_back("part " + std::to_string(index));
        description.instances.push_back({.mesh_index = index,
                                         .world_from_object = parts[index].world_from_object,
                                         .name_index = index,
                                         .first_slot_material = index,
                                         .is_camera_visible = parts[index].is_camera_visible,
                                         .casts_shadow = parts[index].casts_shadow});
    }
    description.media = std::move(media);
    description.lights = std::move(lights);
    return std::make_unique<Scene>(std::move(description), Progress());
}
/// All that a scene was made of.
inline SceneDescription description_of(const Scene& scene) {
    SceneDescription description = scene.description();
    description.lights.assign(scene.lights().begin(), scene.lights().end());
    description.world = scene.world();
    return description;
}
} // namespace tyndall::support
