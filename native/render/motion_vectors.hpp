// SPDX-License-Identifier: GPL-3.0-or-later
// Where what a pixel shows was in the frame before, and will be in the next one, as compositors blur by.
// Based on: Cycles, kernel/geom/motion_triangle and primitive.h: a point of a triangle goes with its vertices, then with
//           its object, and is projected by each frame's camera.
// Differs:  hair and points go with the camera alone.
// Bound:    two matrices per instance, and the vertices of meshes that deform, twice; three projections per sample.
#pragma once
#include "scene/camera.hpp"
#include "scene/scene.hpp"
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace tyndall::render {
/// Another frame, in the space of this frame's scene.
struct NeighbourFrame {
    Camera camera;
    /// By instance: to there, of a point of the scene that moves with it. Empty: all stands still.
    std::vector<mat4> there_from_here = {};
    /// Of instances whose mesh deforms: where its vertices are there, in scene space.
    std::unordered_map<std::uint32_t, std::vector<vec3>> vertices = {};
};
struct NeighbourFrames {
    NeighbourFrame before, after;
    /// Throws InvalidInput where numbers of instances or vertices are not the scene's.
    void require_fit(const Scene& scene) const;
};

/// In pixels of the full frame, x right and y up: from the place now to that before, and from that after to now; 0 where a
/// camera has the point behind it.
[[nodiscard]] vec4 motion_vector(const Scene& scene, const Camera& camera, const Hit& hit, const vec3& position,
                                 const NeighbourFrames& neighbours);
} // namespace tyndall::render
