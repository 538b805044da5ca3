// SPDX-License-Identifier: GPL-3.0-or-later
// What a packed DAG is made of, level by level, and what the same voxels would take without sharing.
// Bound:    each distinct record is read once; a level's references are sorted by the record that they name.
#pragma once
#include "core/progress.hpp"
#include "voxel_dag/packed_dag.hpp"

namespace tyndall::voxel_dag {
struct TreeCounts {
    std::uint32_t level = 1;      ///< 2^level voxels a side.
    std::uint64_t node_count = 0; ///< Distinct ones. None of level 1: 2 x 2 x 2 voxels are a byte of their leaf's word.
    std::uint64_t tree_count = 0; ///< Nodes of an octree that shares nothing.
};
/// From level 1 to the root; nothing of an empty DAG. A DAG that is not usable (require_usable()) is no input. Throws
/// Cancelled.
[[nodiscard]] std::vector<TreeCounts> tree_counts(const PackedDag& dag, const Progress& progress);

/// Of an array of the DAG.
struct PartBytes {
    const char* name;
    std::uint64_t byte_count;
};
/// Adds up to dag.byte_count().
[[nodiscard]] std::array<PartBytes, 4> bytes_by_part(const PackedDag& dag);
} // namespace tyndall::voxel_dag
