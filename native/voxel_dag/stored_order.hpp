// SPDX-License-Identifier: GPL-3.0-or-later
// The order in which a packed DAG's own records list the voxels of the tree that they stand for: entries of attribute
// arrays. A record lists its children by its own octants, before any turn, so that what is stored once lists its voxels
// alike wherever it is used and however it is turned there.
// Based on: Dado et al., Geometry and Attribute Compression for Voxel Scenes, 2016, and Kol, dissertation 2018, 2.4.1: the
//           entry of a voxel is a sum of offsets over the way down.
// Differs:  offsets that go with references, in the world's order, cannot follow a tag. Here they are counts of the children
//           before, and these belong to the record, not to what refers to it. Records of 8^3 and 16^3 have none: they
//           count the bits of their leaves, of which they name some 5 and 20. Larger ones list the counts of all children
//           but the last: above 16^3 nearly every child is one child's only, so that a count each would not be shorter.
// Counts:   of a record of 2 or more children, in the records' order: 6 bits of width, and the voxels of all children but
//           the last; above 32^3 three widths of 6 bits, and per child but the last its voxels, its nodes of 16^3 or more,
//           and the bits of its own counts, 0 where it is shared; then the counts of the children that lie inside.
// Bound:    counts of 1.18 MB for the dragon at 8K^3 beside 11.69 MB of geometry with 48 turns; at 4K^3 0.012 bytes per voxel,
//           where offsets as published, without symmetry, take 0.117. Values in this order take 7 % less
//           to 8 % more than in Morton order: blocks of 16^3 are turned, what lies inside them is not.
//           A look-up reads some 8 leaves beside the records on its way.
#pragma once
#include "core/progress.hpp"
#include "voxel_dag/packed_dag.hpp"
#include <optional>

namespace tyndall::voxel_dag {
inline constexpr std::uint32_t counted_level = 5; ///< Records of 2^5 voxels a side and more have counts.
inline constexpr std::uint32_t least_mean_level =
    4; ///< Nodes of 2^4 and more are numbered; smaller ones are few voxels.

struct StoredOrder {
    std::vector<std::uint64_t> counts; ///< Bits; the root's last.
    /// directories[i]: where the counts of each shared record of 2^(counted_level + i) voxels a side begin.
    std::vector<std::vector<std::uint32_t>> directories;
    std::uint64_t root_bit = 0;   ///< Where the root's begin.
    std::uint64_t node_count = 0; ///< Nodes of the tree of 2^least_mean_level voxels a side and more.

    bool operator==(const StoredOrder&) const = default;
    [[nodiscard]] std::uint64_t byte_count() const;
};
/// The same bits for any number of threads. Throws InvalidInput where counts reach 512 MiB, and Cancelled.
[[nodiscard]] StoredOrder stored_order_of(const PackedDag& dag, const Progress& progress);
/// Throws InvalidInput, which names what does not belong to the DAG. What counts say: require_sound().
void require_usable(const StoredOrder& order, const PackedDag& dag);

/// A node, brick or group of voxels on the way down.
struct StoredPlace {
    PackedNode node;               ///< Of a brick: its pair, and what turns that.
    std::uint64_t counts_bit = 0;  ///< Its counts, where it has any.
    std::uint64_t first_entry = 0; ///< Of its voxels, which follow each other.
    std::uint64_t number = 0;      ///< Among numbered nodes, each before its children; of those alone.
};
[[nodiscard]] inline StoredPlace stored_root(const PackedDag& dag, const StoredOrder& order) {
    return {.node = {.bit = dag.root_bit}, .counts_bit = order.root_bit};
}
/// A node with what there is below.
struct StoredSubtree {
    std::uint32_t level = leaf_level; ///< 2^level voxels a side.
    StoredPlace place;
    std::uint64_t voxel_count = 0;
    std::uint64_t node_count = 0; ///< Numbered ones, itself among them.
};
/// All of it.
[[nodiscard]] inline StoredSubtree stored_tree(const PackedDag& dag, const StoredOrder& order) {
    return {.level = dag.level,
            .place = stored_root(dag, order),
            .voxel_count = dag.voxel_count,
            .node_count = order.node_count};
}
/// A child that is there, by octant of the record; of a node of 8^3 or more.
[[nodiscard]] StoredPlace stored_child(const PackedDag& dag, const StoredOrder& order, std::uint32_t level,
                                       const StoredPlace& place, const PackedHeader& header, std::uint32_t octant);
/// A pair's voxels, by their Morton code before the record that names it is turned: in the order of their entries.
[[nodiscard]] std::uint64_t pair_mask(const PackedDag& dag, std::uint32_t pair);

/// Where the voxels of a cube of 2^level a side around a voxel are; of one voxel, at level 0. Nothing where none is set.
struct StoredCube {
    std::uint64_t first_entry = 0, entry_count = 0; ///< entry_count: of cubes below least_mean_level alone.
    std::uint64_t number = 0;                       ///< Of a numbered node.
};
[[nodiscard]] std::optional<StoredCube> find_stored(const PackedDag& dag, const StoredOrder& order, const Voxel& voxel,
                                                    std::uint32_t level);

/// stored[i] becomes the value of the voxel of entry i, counted from the subtree's first; values are by Morton code. Both
/// have one per voxel. Throws InvalidInput and Cancelled.
void to_stored_order(const PackedDag& dag, const StoredOrder& order, const StoredSubtree& subtree,
                     std::span<const std::uint32_t> values, std::span<std::uint32_t> stored, const Progress& progress);
/// Of the whole tree.
inline void to_stored_order(const PackedDag& dag, const StoredOrder& order, std::span<const std::uint32_t> values,
                            std::span<std::uint32_t> stored, const Progress& progress) {
    to_stored_order(dag, order, stored_tree(dag, order), values, stored, progress);
}
/// The same of numbered nodes; values are by their numbers as the nodes lie in the world, each before its children.
void nodes_to_stored_order(const PackedDag& dag, const StoredOrder& order, const StoredSubtree& subtree,
                           std::span<const std::uint32_t> values, std::span<std::uint32_t> stored,
                           const Progress& progress);
} // namespace tyndall::voxel_dag
