// SPDX-License-Identifier: GPL-3.0-or-later
// DAG -> symmetry-aware DAG: subtrees that are equal after a turn of the cube become one, references say which turn.
// Based on: Jaspe, dissertation 2018, 5.3 and 5.4.1, where the turns are the 8 reflections.
// Differs:  48 turns where asked for. Works on the nodes of a DAG, which are distinct, not on the tree. No search for
//           a match: each node is turned into its canonical form, which is hashed. A turn that leaves a child as it is
//           (its stabilizer) makes tags equal, so that tags are compared as cosets, named by their smallest element:
//           no merge is missed [formula-notes, Voxel DAGs]. The root has a tag, too.
// Bound:    a node whose smallest child number is there once has 1 candidate of 8 turns, or 6 of 48: those that bring
//           that child to octant 0.
#pragma once
#include "core/progress.hpp"
#include "voxel_dag/dag.hpp"

namespace tyndall::voxel_dag {
struct MergeConfig {
    Symmetry symmetry = Symmetry::Cube;
    std::uint64_t memory_budget_bytes = ~std::uint64_t{0}; ///< For tables and result, the plain DAG apart.
};

/// At most what merging takes beside the plain DAG.
[[nodiscard]] std::uint64_t estimated_merge_bytes(const Dag& plain);

/// The same voxels. Nodes are in the order in which the plain DAG has the first of those that became one: equal for any
/// number of threads. Throws InvalidInput (a DAG that has a symmetry already, too small a budget) and Cancelled.
[[nodiscard]] Dag merge_symmetric(const Dag& plain, const MergeConfig& config, const Progress& progress);
} // namespace tyndall::voxel_dag
