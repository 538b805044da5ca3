// SPDX-License-Identifier: GPL-3.0-or-later
// Sub-cubes' DAGs, in files -> the DAG of the whole, level by level from the leaves up.
// Based on: Jaspe, dissertation 2018, 5.3: out of core, sub-volumes are reduced on their own, and merged bottom-up.
// Differs:  the parts come in Morton order, and a node is numbered where it first appears: the result is what build_dag()
//           and merge_symmetric() make of all voxels at once, to the last bit. Parts may have been merged already: a
//           part's node, turned into what it has become, takes its parents' tags along. Where a level's table of
//           distinct nodes would not fit the budget, the parts are read several times, and each time those nodes are
//           looked up whose hash is that time's.
// Bound:    6 bytes per node of a level and of the one below, parts counted singly, and the table; beside them one level
//           of one part.
#pragma once
#include "voxel_dag/part_file.hpp"
#include <functional>
#include <span>

namespace tyndall::voxel_dag {
struct JoinConfig {
    std::uint32_t level = leaf_level;                      ///< 2^level voxels a side, of the whole.
    std::uint32_t part_level = leaf_level;                 ///< Of each part.
    Symmetry symmetry = Symmetry::Cube;                    ///< What the parts have, too.
    std::uint64_t memory_budget_bytes = ~std::uint64_t{0}; ///< For tables and result.
};
struct JoinStatistics {
    std::uint32_t most_passes = 0; ///< Over the parts, of any level; 1 where every table fits.
};
struct JoinResult {
    Dag dag;
    JoinStatistics statistics;
};
/// Of parts in the order of their codes. report(share of the work that is done) is called level by level. Throws
/// InvalidInput where 2^32 nodes of one level come together or the budget does not suffice; IoError; and Cancelled.
[[nodiscard]] JoinResult join_parts(std::span<const PartFile> parts, const JoinConfig& config, const Progress& progress,
                                    const std::function<void(double)>& report);
} // namespace tyndall::voxel_dag
