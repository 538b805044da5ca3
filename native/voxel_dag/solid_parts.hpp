// SPDX-License-Identifier: GPL-3.0-or-later
// Solids sub-cube by sub-cube: those that lie inside without a triangle, and what crosses the columns of one.
// Differs:  from solid_fill.hpp in no voxel. Whether a column begins inside of a sub-cube is what all triangles before it,
//           along x, add up to: each sub-cube counts these by itself, so that parts stay independent of each other.
//           Sub-cubes without triangles are all inside or all outside, and one column tells.
// Bound:    crossings are counted once for each sub-cube behind them in its row; 4 bytes per column of a sub-cube, and 16
//           per crossing within it.
#pragma once
#include "voxel_dag/column_crossings.hpp"
#include "voxel_dag/dag.hpp"
#include "voxel_dag/sub_volumes.hpp"

namespace tyndall::voxel_dag {
/// Triangles that lie before the cube, along x, and are in no sub-cube.
[[nodiscard]] std::vector<std::uint32_t> triangles_before(const SnappedMesh& mesh);
/// The sub-cubes, and those that the mesh winds around without a triangle there. Throws Cancelled.
[[nodiscard]] SubVolumes with_inside(const SnappedMesh& mesh, const SubVolumes& parts,
                                     std::span<const std::uint32_t> before, const Progress& progress);
/// What crosses a sub-cube's columns, in it and before it.
[[nodiscard]] ColumnCrossings crossings_of_part(const SnappedMesh& mesh, const SubVolumes& parts,
                                                std::span<const std::uint32_t> before, std::size_t part,
                                                const Progress& progress);
/// Of a cube that is full.
[[nodiscard]] Dag full_dag(std::uint32_t level, Symmetry symmetry);
} // namespace tyndall::voxel_dag
