// SPDX-License-Identifier: GPL-3.0-or-later
// Voxels as a mesh of boxes: a square for every face between a voxel that is set and one that is not, corners shared.
// Differs:  squares are not joined to larger ones: each belongs to one voxel, and has its colour.
// Bound:    per square 2 triangles of 12 bytes and 4 for its voxel; per corner, of which there are about as many, 24 and
//           some 20 while it is made.
#pragma once
#include "core/math.hpp"
#include "core/progress.hpp"
#include "voxel_dag/leaf_masks.hpp"

namespace tyndall::voxel_dag {
struct BoxMesh {
    std::vector<dvec3> positions; ///< In voxels: voxel (x, y, z) is the cube from there to (x + 1, y + 1, z + 1).
    /// Two per square, one after the other; seen from outside, corners go round against the clock. Each edge is passed as
    /// often one way as the other: the mesh is closed, though where voxels touch by an edge four squares meet.
    std::vector<uvec3> triangles;
    std::vector<std::uint32_t> voxel_numbers; ///< Per square: its voxel, counted in Morton order.
};
/// Throws InvalidInput, before the work where the budget does not suffice, with what the mesh would take; and Cancelled.
[[nodiscard]] BoxMesh box_mesh_of(const LeafMasks& leaves, std::uint64_t memory_budget_bytes, const Progress& progress);
} // namespace tyndall::voxel_dag
