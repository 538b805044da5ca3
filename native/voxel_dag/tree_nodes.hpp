// SPDX-License-Identifier: GPL-3.0-or-later
// The way down a DAG, in its arrays or in its packed bits, by functions of the same names: what follows it is written once.
#pragma once
#include "voxel_dag/cube_group.hpp"
#include "voxel_dag/packed_dag.hpp"

namespace tyndall::voxel_dag {
/// Where one is in an array of nodes: what PackedNode is in packed bits.
struct Node {
    std::uint32_t number = 0, turn = 0;
};
inline Node root_of(const Dag& dag) { return {.turn = dag.root_tag}; }
inline PackedNode root_of(const PackedDag& dag) { return {.bit = dag.root_bit}; }

/// A node of 8^3 or more on the way, with the mask of its children by its own octants.
struct OpenNode {
    std::uint32_t child_mask, number;
};
inline OpenNode opened(const Dag& dag, std::uint32_t level, const Node& node) {
    return {.child_mask = dag.levels[level - leaf_level - 1].child_masks[node.number], .number = node.number};
}
inline PackedHeader opened(const PackedDag& dag, std::uint32_t level, const PackedNode& node) {
    return packed_header(dag, level, node);
}

inline Node child_of(const Dag& dag, std::uint32_t level, const Node& node, const OpenNode&, std::uint32_t octant) {
    const DagLevel& nodes = dag.levels[level - leaf_level - 1];
    const std::size_t reference = nodes.reference(node.number, octant);
    return {.number = nodes.children[reference], .turn = cube_group.product[node.turn][nodes.tag(reference)]};
}
inline PackedNode child_of(const PackedDag& dag, std::uint32_t level, const PackedNode& node,
                           const PackedHeader& header, std::uint32_t octant) {
    if (level > leaf_level + 1)
        return packed_child(dag, level, node, header, octant);
    return {.bit = packed_pair(dag, header, octant), .turn = node.turn}; // a leaf lies behind its pair
}

/// A leaf as it is stored, and what turns it into the one that is there.
struct TurnedLeaf {
    std::uint64_t mask = 0;
    std::uint32_t turn = 0;
};
inline TurnedLeaf leaf_of(const Dag& dag, const Node& node) {
    return {.mask = dag.leaves[node.number], .turn = node.turn};
}
inline TurnedLeaf leaf_of(const PackedDag& dag, const PackedNode& node) {
    const PackedLeaf leaf = packed_leaf(dag, static_cast<std::uint32_t>(node.bit));
    return {.mask = leaf.mask, .turn = cube_group.product[node.turn][leaf.tag]};
}
/// Its octants of 2 x 2 x 2 voxels that have any, and the voxels of one, bit by bit; both as they are stored.
inline std::uint32_t groups_of(const TurnedLeaf& leaf) { return occupied_bytes(leaf.mask); }
inline std::uint32_t group_of(const TurnedLeaf& leaf, std::uint32_t octant) {
    return static_cast<std::uint32_t>(leaf.mask >> 8 * octant & 0xff);
}
} // namespace tyndall::voxel_dag
