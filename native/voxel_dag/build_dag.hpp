// SPDX-License-Identifier: GPL-3.0-or-later
// Voxels -> DAG: equal subtrees become one, from the leaves to the root.
// Based on: Kämpe, Sintorn, Assarsson 2013, section 4, level by level from below; Jaspe, dissertation 2018, 5.4.1.
// Differs:  hashed, not sorted. A thread takes a stretch of the Morton order through all levels at once, so that only
//           distinct nodes ever leave its cache: the SVO is never in memory. Numbers are whatever the threads make
//           them, until one pass from the root down numbers nodes in the order of first use.
// Bound:    one look-up per brick and node of the SVO, with its miss of the cache asked for in time.
#pragma once
#include "core/progress.hpp"
#include "voxel_dag/dag.hpp"

namespace tyndall::voxel_dag {
struct BuildConfig {
    std::uint64_t memory_budget_bytes = ~std::uint64_t{0}; ///< For tables and result, the voxels apart.
};

/// What building begins with, for so many bricks of a surface: it takes more where they repeat less than those do.
[[nodiscard]] std::uint64_t estimated_build_bytes(std::size_t brick_count, std::uint32_t level);

/// Nodes of each level are in the order of first use, from octant 0 of the root on: equal voxels give an equal DAG,
/// whatever the number of threads. Throws InvalidInput (voxels that are not usable, a budget that does not suffice:
/// before the work where the estimate says so) and Cancelled.
[[nodiscard]] Dag build_dag(const LeafMasks& voxels, const BuildConfig& config, const Progress& progress);
} // namespace tyndall::voxel_dag
