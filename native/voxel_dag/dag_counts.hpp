// SPDX-License-Identifier: GPL-3.0-or-later
// What a DAG is made of, level by level, and how many bytes it takes in the published layout, for comparison.
// Based on: Jaspe, dissertation 2018, 5.4.3: nodes of a level by falling number of references, in half-words; a node is a
//           header of 2 bits per child and, per child, 2 bytes (3 bits of tag, 13 of offset) or 4.
//           Before it: Kämpe, Sintorn, Assarsson 2013, section 4: 8 to 36 bytes per node.
// Differs:  counted, not written. Tags of the 48 take 6 of those bits.
// Bound:    one pass over the references and a counting sort per level.
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

/// Bytes of nodes and leaves in Kämpe's layout, in words of 32 bits: a mask, then a reference per child, and 2 x 2 x 2
/// voxels are a node as others are, but shared by all that have the same, so that they cost nothing.
[[nodiscard]] std::uint64_t word_bytes(const Dag& dag);
/// Bytes of nodes and leaves in the published layout, without its header of some 20 bytes.
[[nodiscard]] std::uint64_t half_word_bytes(const Dag& dag);
} // namespace tyndall::voxel_dag
