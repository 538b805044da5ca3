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

/// What a node of some DAG has become in the one that is made of it.
struct MergedNode {
    std::uint32_t number;    ///< Of the node that stands for it.
    std::uint8_t tag;        ///< What turns that one into it: the smallest of its coset.
    std::uint8_t stabilizer; ///< Of that one.
};
/// Of a node of `nodes`, whose references name what merged_of(reference) says; as it is, without a symmetry.
template <class MergedOf>
[[nodiscard]] Canonical<TurnedChildren> canonical_node(const DagLevel& nodes, std::size_t node, Symmetry symmetry,
                                                       const MergedOf& merged_of) {
    TurnedChildren turned{};
    std::array<std::uint8_t, 8> stabilizers{};
    std::size_t at = nodes.first_children[node];
    for (std::uint32_t octant = 0; octant < 8; ++octant) {
        if ((nodes.child_masks[node] >> octant & 1) == 0)
            continue;
        const MergedNode child = merged_of(at++);
        turned.children[octant] = child.number + 1;
        turned.tags[octant] = child.tag;
        stabilizers[octant] = child.stabilizer;
    }
    return symmetry == Symmetry::None ? Canonical<TurnedChildren>{.node = turned, .tag = 0, .stabilizer = 0}
                                      : canonical_node(turned, stabilizers, symmetry);
}
} // namespace tyndall::voxel_dag
