// SPDX-License-Identifier: GPL-3.0-or-later
// Voxels of a DAG, or the cubes of 2^level of them that have any, all at once: what exporters go over.
// Bound:    16 bytes per brick of 4^3 that comes out; every voxel of the DAG is decoded, whatever the level.
#pragma once
#include "core/progress.hpp"
#include "voxel_dag/packed_dag.hpp"

namespace tyndall::voxel_dag {
/// As voxels of a cube that has as many of these cubes a side. Throws InvalidInput where they are fewer than 4.
[[nodiscard]] LeafMasks coarse_voxels(const LeafMasks& leaves, std::uint32_t level);
/// Throws InvalidInput, too, as soon as the bricks take more than the budget; and Cancelled.
[[nodiscard]] LeafMasks coarse_voxels(const PackedDag& dag, std::uint32_t level, std::uint64_t memory_budget_bytes,
                                      const Progress& progress);
} // namespace tyndall::voxel_dag
