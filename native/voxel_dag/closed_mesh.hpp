// SPDX-License-Identifier: GPL-3.0-or-later
// Whether a mesh of whole steps closes: along each edge as many triangles run one way as the other.
// Differs:  vertices of the same steps are one, so that meshes whose faces have vertices of their own close, too.
// Bound:    sorts vertices and edges; 48 bytes per triangle and 8 per vertex.
#pragma once
#include "voxel_dag/snapped_mesh.hpp"
#include <optional>

namespace tyndall::voxel_dag {
/// An edge of a triangle, from corner number `corner` to the one after it.
struct OpenEdge {
    std::size_t triangle;
    int corner;
};
/// The first, by triangles, of those edges along which the ways do not add up to 0; nothing: the mesh closes.
[[nodiscard]] std::optional<OpenEdge> open_edge(const SnappedMesh& mesh, const Progress& progress);
} // namespace tyndall::voxel_dag
