// SPDX-License-Identifier: GPL-3.0-or-later
// What a DAG is made of, level by level. (What it takes in published layouts: benchmarks/baselines.)
// Bound:    one pass over the references.
#pragma once
#include "voxel_dag/dag.hpp"

namespace tyndall::voxel_dag {
struct LevelCounts {
    std::uint32_t level = leaf_level; ///< 2^level voxels a side.
    std::size_t node_count = 0;       ///< Distinct ones; leaves at leaf_level.
    std::size_t reference_count = 0;  ///< From these nodes to the level below.
    std::size_t once_count = 0;       ///< Nodes that one reference names, the root's included.
};
/// From the leaves to the root; nothing of an empty DAG.
[[nodiscard]] std::vector<LevelCounts> level_counts(const Dag& dag);
} // namespace tyndall::voxel_dag
