// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/motion_vectors.hpp"
#include "core/errors.hpp"

namespace tyndall::render {
static void require_fit(const NeighbourFrame& frame, const Scene& scene) {
    const SceneDescription& description = scene.description();
    require_usable(frame.camera);
    require(frame.there_from_here.empty() || frame.there_from_here.size() == description.instances.size(),
            "a neighbouring frame has ", frame.there_from_here.size(), " instances, not ",
            description.instances.size());
    for (const auto& [instance, vertices] : frame.vertices) {
        require(instance < description.instances.size(), "a neighbouring frame names instance ", instance, " of ",
                description.instances.size());
        const std::size_t count =
            description.meshes[description.instances[instance].mesh_index]->arrays().positions.size();
        require(vertices.size() == count, "instance ", instance, " has ", vertices.size(),
                " vertices in a neighbouring frame, not ", count);
    }
}

void NeighbourFrames::require_fit(const Scene& scene) const {
    render::require_fit(before, scene);
    render::require_fit(after, scene);
}

static vec3 place_in(const NeighbourFrame& frame, const Scene& scene, const Hit& hit, const vec3& position) {
    const SceneDescription& description = scene.description();
    if (hit.instance >= description.instances.size())
        return position;
    if (const auto moved = frame.vertices.find(hit.instance); moved != frame.vertices.end()) {
        const SharedMeshArrays& mesh = description.meshes[description.instances[hit.instance].mesh_index]->arrays();
        const uvec3& corners = mesh.triangles[hit.triangle];
        const vec2 b = hit.barycentrics;
        return (1.0f - b.x - b.y) * moved->second[corners.x] + b.x * moved->second[corners.y] +
               b.y * moved->second[corners.z];
    }
    return frame.there_from_here.empty() ? position : vec3(frame.there_from_here[hit.instance] * vec4(position, 1.0f));
}

vec4 motion_vector(const Scene& scene, const Camera& camera, const Hit& hit, const vec3& position,
                   const NeighbourFrames& neighbours) {
    const auto now = camera.raster_position(position);
    if (!now)
        return vec4(0.0f);
    const auto before = neighbours.before.camera.raster_position(place_in(neighbours.before, scene, hit, position));
    const auto after = neighbours.after.camera.raster_position(place_in(neighbours.after, scene, hit, position));
    return {before ? *before - *now : vec2(0.0f), after ? *now - *after : vec2(0.0f)};
}
} // namespace tyndall::render
