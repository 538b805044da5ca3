// SPDX-License-Identifier: GPL-3.0-or-later
// Whether what a packed DAG says leads nowhere but to its own parts: a file with right checksums may say anything.
// Proof:    records lie one behind the other, level by level, the root's last, each with what lies inside it, and each
//           names what its level's dictionary below has: so every way down ends in a leaf, no bit belongs to two records,
//           and each is read once. What the tree has of voxels and nodes is added up on the way, once per record, and every
//           number that says so is compared.
// Bound:    one pass over the bits, threads side by side: the 1.4 M nodes of the dragon at 8K^3 in 68 ms of processor.
#pragma once
#include "voxel_dag/stored_order.hpp"

namespace tyndall::voxel_dag {
/// Both are usable (require_usable()); order may be null. Throws InvalidInput, which names the first record found that lies,
/// and Cancelled. Whatever may be asked of a DAG that passes stays inside it.
void require_sound(const PackedDag& dag, const StoredOrder* order, const Progress& progress);
} // namespace tyndall::voxel_dag
