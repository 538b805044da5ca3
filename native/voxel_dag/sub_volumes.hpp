// SPDX-License-Identifier: GPL-3.0-or-later
// A cube of voxels as smaller cubes of one size, each with the triangles that may meet it: what is voxelized one by one
// gives, put together, the very voxels of the whole, as all are of one mesh that is snapped once.
// Differs:  triangles are told apart by their boxes. A box reaches into a sub-cube wherever a voxel of its triangle lies
//           there, ties included: both round down.
// Bound:    20 ns per triangle and level of halving; 4 bytes per triangle and sub-cube.
#pragma once
#include "voxel_dag/snapped_mesh.hpp"

namespace tyndall::voxel_dag {
struct SubVolumes {
    std::uint32_t level;                  ///< 2^level voxels a side.
    std::vector<std::uint64_t> codes;     ///< Morton codes of those that triangles may meet, ascending.
    std::vector<std::size_t> first;       ///< Of each, and one past: where its triangles begin.
    std::vector<std::uint32_t> triangles; ///< Indices in the mesh.

    [[nodiscard]] std::size_t count() const { return codes.size(); }
};
/// The largest sub-cubes of at most 2^most_part_level voxels a side that have at most so many bricks of 4^3, as far as the
/// triangles' areas tell. Throws InvalidInput for 2^31 triangles or more or where no size is small enough, and Cancelled.
[[nodiscard]] SubVolumes split(const SnappedMesh& mesh, VoxelizeRule rule, std::uint64_t most_bricks,
                               std::uint32_t most_part_level, const Progress& progress);

/// The triangles of one sub-cube, from its lower corner on, with three positions each.
struct SubMesh {
    std::vector<uvec3> triangles;
    SnappedMesh mesh; ///< Refers to them.
};
/// Some triangles of a mesh, from the lower corner of a sub-cube of 2^part_level voxels a side on, in a cube of 2^level.
[[nodiscard]] SubMesh moved_mesh(const SnappedMesh& mesh, std::span<const std::uint32_t> triangles, const Voxel& at,
                                 std::uint32_t part_level, std::uint32_t level);
[[nodiscard]] SubMesh sub_mesh(const SnappedMesh& mesh, const SubVolumes& parts, std::size_t part);
} // namespace tyndall::voxel_dag
