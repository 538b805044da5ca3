// SPDX-License-Identifier: GPL-3.0-or-later
// Of all turns of a leaf or node, the one that stands for them, and the turns that make it.
#pragma once
#include "voxel_dag/dag.hpp"
#include "voxel_dag/write_level.hpp"

namespace tyndall::voxel_dag {
template <class Node>
struct Canonical {
    Node node;               ///< Equal for two nodes exactly if a turn makes one of the other.
    std::uint8_t tag;        ///< The smallest element that turns it back into what was given.
    std::uint8_t stabilizer; ///< Index in subgroups(): the elements that leave it as it is.
};

/// The smallest of a leaf's images as a number.
[[nodiscard]] Canonical<std::uint64_t> canonical_leaf(std::uint64_t leaf, Symmetry symmetry);
/// Of a node whose children are canonical, and whose tags are the smallest of their cosets; `stabilizers` are those of
/// the children. The smallest child number lies in octant 0 then.
[[nodiscard]] Canonical<TurnedChildren>
canonical_node(const TurnedChildren& node, const std::array<std::uint8_t, 8>& stabilizers, Symmetry symmetry);
} // namespace tyndall::voxel_dag
