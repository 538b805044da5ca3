// SPDX-License-Identifier: GPL-3.0-or-later
// DAG -> packed bits (packed_dag.hpp).
// Based on: Jaspe, dissertation 2018, 5.4.3, for the order of a level's nodes: by falling number of references.
// Differs:  what has one reference goes into its parent's record. Records are stored upright (upright.hpp).
// Bound:    a bit is copied once per level of records around it.
#pragma once
#include "core/progress.hpp"
#include "voxel_dag/packed_dag.hpp"

namespace tyndall::voxel_dag {
/// What packing takes at most, the DAG and what comes out among it: measured on scans and architecture.
[[nodiscard]] std::uint64_t estimated_pack_bytes(const Dag& dag);

struct PackConfig {
    /// Records of 16^3 inside others have tags of their own: 1 MB less for the dragon at 8K^3.
    bool has_inner_tags = true;
};

/// Any symmetry; the same bits for any number of threads. Throws InvalidInput where a level's shared records reach 512 MiB,
/// and Cancelled.
[[nodiscard]] PackedDag pack_dag(const Dag& dag, const Progress& progress, const PackConfig& config = {});
} // namespace tyndall::voxel_dag
