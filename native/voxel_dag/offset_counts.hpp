// SPDX-License-Identifier: GPL-3.0-or-later
// Bytes of a DAG whose references carry offsets into an attribute array in depth-first order, as published, step by step:
// the baseline that benchmarks compare packed DAGs and their counts with.
// Based on: Kol, dissertation, TU Delft 2018, 2.4.1, 2.4.4 and table 2.3: every node of the tree has an entry; an offset is
//           the child's entry less the node's.
// Differs:  counted, not written. Nodes of 2 x 2 x 2 voxels are a mask, their offsets its set bits; they are shared by all
//           that have the same, 255 at most. Pointers by level count bytes of the level below. Of a level's pointers those
//           go into the table that it pays for. Without symmetry: an offset in the world's order cannot follow a turn.
// Bound:    one pass over the references per level, and a sort of the nodes by use.
#pragma once
#include "voxel_dag/dag.hpp"

namespace tyndall::voxel_dag {
/// What is done to masks of 4 bytes, pointers of 4 and offsets of 4.
struct OffsetLayout {
    bool has_offsets = true;          ///< False: no attributes.
    bool has_implicit_first = false;  ///< The first child's offset is +1, and not stored.
    bool has_offset_bytes = false;    ///< Offsets in as many bytes as their level needs.
    bool has_pointer_bytes = false;   ///< Pointers likewise.
    bool has_byte_masks = false;      ///< Masks without 24 bits of padding.
    bool has_pointers_by_use = false; ///< 6, 14 or 22 bits into the level's table, else 30, and 2 bits of type.

    /// All of them.
    [[nodiscard]] static OffsetLayout combined();
};
/// Throws InvalidInput for a DAG with tags.
[[nodiscard]] std::uint64_t offset_dag_bytes(const Dag& dag, const OffsetLayout& layout);
} // namespace tyndall::voxel_dag
