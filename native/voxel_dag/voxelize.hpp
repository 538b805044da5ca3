// SPDX-License-Identifier: GPL-3.0-or-later
// Triangle meshes to voxels: the surface, by a rule that leaves no gaps, exactly.
// Based on: Schwarz and Seidel, Fast Parallel Surface and Solid Voxelization on GPUs, ACM TOG 29(6), 2010, section 3: a
//           triangle meets a voxel unless its plane, or an edge as seen along an axis, separates them. The voxel is a
//           cube (conservative) or the octahedron between the centres of its faces (thin).
// Differs:  vertices are snapped to 1/256 voxel and every test is one of integers: a voxel is set or not whatever the
//           order of triangles and of their corners, the number of threads, or the tile that is at work. Ties have a
//           side: the mesh lies as if it were moved by (e, e^2, e^3), with e > 0 below any number. A test that ends in
//           0 then counts where the first component of its direction that is not 0 (x before y before z) is negative;
//           a plane between two voxels belongs to the upper one. As no tie is left, what holds for meshes in general
//           position holds for every mesh:
//           - conservative: each point of the moved mesh lies within a voxel that is set. A closed mesh stops every
//             path from neighbour to neighbour, by faces, edges or corners (26-separating);
//           - thin: each piece of the moved mesh that passes a voxel's centre within half a voxel along an axis sets
//             that voxel. A closed mesh stops every path by faces (6-separating), and each column along the main axis
//             of a triangle's normal has one voxel of it at most.
// Bound:    per triangle and tile of 64^3 voxels about 0.2 us; per word of 64 voxels in a row that it meets, one OR; 16
//           bytes per brick that comes out.
#pragma once
#include "core/math.hpp"
#include "core/progress.hpp"
#include "voxel_dag/leaf_masks.hpp"
#include <cstdint>
#include <optional>
#include <span>

namespace tyndall::voxel_dag {
enum class VoxelizeRule : std::uint8_t {
    Thin,         ///< 6-separating: no way through from face to face.
    Conservative, ///< 26-separating: every voxel that the mesh touches.
};
struct Cube {
    dvec3 lower_m = dvec3(0); ///< Its lowest corner.
    double side_m = 1;        ///< Above 0.
};
struct VoxelizeConfig {
    std::uint32_t resolution = 1024; ///< Voxels a side, a power of two in [4, 131072].
    VoxelizeRule rule = VoxelizeRule::Thin;
    /// What is voxelized; the mesh may reach beyond. Without: from the lowest corner of the box around the triangles,
    /// as long as that box's longest side. What lies on an upper face of the cube belongs to the last voxels.
    std::optional<Cube> bounds_m = std::nullopt;
    std::uint64_t memory_budget_bytes = ~std::uint64_t{0}; ///< For the voxels that come out.
};
struct VoxelizeStatistics {
    std::uint64_t voxel_count = 0;
    std::uint64_t tile_count = 0;             ///< Tiles of 64^3 voxels, or the whole cube, that triangles may meet.
    std::uint64_t triangle_tile_count = 0;    ///< Triangles, counted in each of these tiles.
    std::uint64_t outside_triangle_count = 0; ///< Triangles that the cube has no part of.
};
struct VoxelizeResult {
    LeafMasks leaves; ///< Empty where no triangle meets the cube.
    VoxelizeStatistics statistics;
};
/// Throws InvalidInput, which names the setting, the first vertex that is not finite or lies 2^32 voxels or more from
/// the cube's lower corner, or the first triangle that has a vertex which is not there, or a budget that does not suffice and
/// what would fit; and Cancelled.
[[nodiscard]] VoxelizeResult voxelize(std::span<const vec3> positions_m, std::span<const uvec3> triangles,
                                      const VoxelizeConfig& config, const Progress& progress);
[[nodiscard]] VoxelizeResult voxelize(std::span<const dvec3> positions_m, std::span<const uvec3> triangles,
                                      const VoxelizeConfig& config, const Progress& progress);
} // namespace tyndall::voxel_dag
