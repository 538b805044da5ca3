// SPDX-License-Identifier: GPL-3.0-or-later
// The voxels within a closed mesh, added to those of its surface.
// Based on: Schwarz and Seidel, Fast Parallel Surface and Solid Voxelization on GPUs, ACM TOG 29(6), 2010, section 4: along
//           each column of voxels, centres between two crossings of the mesh lie within.
// Differs:  crossings are counted with the side that the mesh shows (the winding number), not by parity: where closed
//           parts overlap, all of them is filled; a shell that is turned inwards leaves its hollow empty. All is exact, by
//           the tie rule of voxelize.hpp: the mesh lies as if it were moved by (e, e^2, e^3), so that no centre lies on
//           it, and no column passes through an edge. The result depends on neither the order of triangles nor the
//           number of threads. A mesh that does not close has no inside, and is refused with one of its edges: a
//           flood from outside would fill nothing there without a word, and fill hollows as well.
// Bound:    one division per crossing, about half of the surface's voxels; 16 bytes each. Per tile of 64^3 voxels 4,096
//           columns are looked at, whatever is in them, and full bricks are 16 bytes for their 64 voxels.
#pragma once
#include "voxel_dag/column_crossings.hpp"

namespace tyndall::voxel_dag {
/// The voxels of `surface`, made of this mesh with this configuration, and those whose centres the mesh winds around a
/// number of times that is not 0. Throws InvalidInput, which names an edge at which the mesh is open, or the budget and
/// what would be needed; and Cancelled.
[[nodiscard]] LeafMasks solid_fill(std::span<const vec3> positions_m, std::span<const uvec3> triangles,
                                   const VoxelizeConfig& config, const LeafMasks& surface, const Progress& progress);
[[nodiscard]] LeafMasks solid_fill(std::span<const dvec3> positions_m, std::span<const uvec3> triangles,
                                   const VoxelizeConfig& config, const LeafMasks& surface, const Progress& progress);

/// Throws InvalidInput, which names an edge at which a mesh is open, by the positions that it was snapped from; and
/// Cancelled.
void require_closed(const SnappedMesh& mesh, std::span<const vec3> positions_m, const Progress& progress);
void require_closed(const SnappedMesh& mesh, std::span<const dvec3> positions_m, const Progress& progress);
/// The voxels of `surface`, and those between crossings of their columns. Throws as solid_fill() does.
[[nodiscard]] LeafMasks filled(const ColumnCrossings& crossings, const LeafMasks& surface, const VoxelizeConfig& config,
                               const Progress& progress);
} // namespace tyndall::voxel_dag
