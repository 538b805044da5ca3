// SPDX-License-Identifier: GPL-3.0-or-later
// How the records of a packed DAG are turned where they are stored: upright, so that neighbours are alike.
// Based on: the free choice that a DAG with turns leaves: a node may be stored in any of them, as its references' tags say
//           how it is to be turned back.
// Differs:  from first come, first stored (Jaspe, dissertation 2018, 5.4.1), where tags of one parent differ at random. A
//           surface's leaves of 8^3 and 16^3 lean alike: each votes for the turns that make it what the DAG has as its
//           leaf, and those with the most votes are taken. Records then name few leaves in few turns, and most tags change
//           nothing. What lies inside 16^3 is turned with it; a record of 16^3 inside one of 32^3 needs a tag of its own
//           for that, which pays: 14.18 -> 11.69 MB for the dragon at 8K^3, 8.19 -> 7.58 for Sponza. (A further round
//           that weighs turns by how often their leaves are used gains 0.3 %.)
// Bound:    a few additions per reference of 8^3 and 16^3; 1 byte per node and leaf.
#pragma once
#include "core/progress.hpp"
#include "voxel_dag/dag.hpp"
#include "voxel_dag/subgroups.hpp"
#include <functional>

namespace tyndall::voxel_dag {
struct Upright {
    bool has_inner_tags = false; ///< Whether records of 16^3 that lie inside others are turned on their own.
    /// By level and node: what turns it into what is stored.
    std::vector<std::vector<std::uint8_t>> turns;
    /// Per leaf as it is, and per shared node of 8^3 as it is stored: the subgroup that leaves it so. Others have none, 0.
    std::vector<std::uint8_t> leaf_stabilizers, smallest_stabilizers;

    /// The elements that leave an 8^3 as it is stored.
    [[nodiscard]] std::uint64_t keeping(std::size_t smallest) const {
        return subgroups().members[smallest_stabilizers[smallest]];
    }
    /// Of all elements that turn a leaf into the same brick, the smallest.
    [[nodiscard]] std::uint32_t brick_turn(std::uint32_t leaf, std::uint32_t element) const {
        return subgroups().coset[leaf_stabilizers[leaf]][element];
    }
};
/// is_shared(levels[i], node): a record that references name; others lie inside the one that has their one reference, turned
/// with it; in `levels[1]`, 16^3, turned on their own where has_inner_tags. The root is stored as it is in the world.
[[nodiscard]] Upright upright_turns(const Dag& dag, bool has_inner_tags,
                                    const std::function<bool(std::size_t i, std::uint32_t node)>& is_shared,
                                    const Progress& progress);
} // namespace tyndall::voxel_dag
