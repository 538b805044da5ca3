// SPDX-License-Identifier: GPL-3.0-or-later
// A DAG as packed bits that are followed in place: what is used once lies inside its parent's record.
// Based on: Jaspe, dissertation 2018, 5.4.3: nodes by falling number of references, short references to the first ones.
// Differs:  above 8^3 almost nothing is shared: at 8K^3 of a scan 71 % of the nodes of 8^3 and 97 % of those of 16^3 have
//           one reference. Those take no reference at all: they lie in their parent's record, turned as it needs them.
//           Nodes of two or more references make a dictionary per level, in four widths of ranks (rank_classes.hpp).
//           Leaves are named with their tag, as pairs, by nodes of 8^3.
//           Records are stored upright (upright.hpp): siblings name few leaves, and few tags, of which the first in their
//           level's list changes nothing.
// Record:   the rank of its child mask in its level's list: 2 bits of class, and as many as that class has; per child 2
//           bits of class; per child its field: in 8^3, the rank of a pair; above, for class 0, which lies inside, the rank
//           of a tag in 32^3, else nothing; for others a rank in the dictionary below and the rank of a tag; above
//           16^3, with two or more children inside, 5 bits of width and the lengths of all but the last; then the
//           records inside.
// Bound:    the dragon at 8K^3, 98.1 M voxels of the thin rule: 11.7 MB with 48 turns (21.6 in the published layout), 15.1
//           with 8, 19.4 with none. One load of 64 bits per field.
#pragma once
#include "voxel_dag/bit_stream.hpp"
#include "voxel_dag/dag.hpp"
#include "voxel_dag/rank_classes.hpp"
#include <array>
#include <optional>

namespace tyndall::voxel_dag {
/// How the records of one level name what is below them, and where its own shared records are.
struct PackedLevel {
    RankClasses mask_classes;                    ///< Of ranks in child_masks.
    std::array<std::uint8_t, 256> child_masks{}; ///< By rank: those that the level's records have, then zeros.
    RankClasses classes;                         ///< Of ranks below.
    std::array<std::uint32_t, 4> field_bits;     ///< Per class: a rank below, and a tag's rank.
    std::array<std::uint8_t, 64> tags{};         ///< By rank: those that the level's records name, then zeros.
    std::vector<std::uint32_t> directory;        ///< Bit at which every directory_step(level)-th shared record begins.

    bool operator==(const PackedLevel&) const = default;
};
/// Records of 8^3 are short and found by their lengths; a step of 4 costs 1.5 lengths on average.
[[nodiscard]] constexpr std::uint32_t directory_step(std::uint32_t level) { return level == leaf_level + 1 ? 4 : 1; }

struct PackedDag {
    std::uint32_t level = leaf_level; ///< 2^level voxels a side.
    std::uint32_t tag_bits = 0;       ///< 0, 3 or 6: as many turns as the DAG's symmetry has.
    std::uint32_t leaf_bits = 0;      ///< Of a leaf's number in a pair.
    std::vector<std::uint64_t> leaves;
    std::vector<std::uint64_t> pairs;   ///< By rank: leaf_bits of a leaf's number, tag_bits of its tag; packed.
    std::vector<std::uint64_t> records; ///< All levels' shared records and what lies inside them; the root's last.
    std::vector<PackedLevel> levels;    ///< levels[i]: 2^(3 + i) voxels a side.
    std::uint64_t root_bit = 0;         ///< Where the root's record begins.
    std::uint64_t voxel_count = 0,
                  node_count = 0; ///< Of the DAG that was packed: voxels, and distinct nodes and leaves.

    bool operator==(const PackedDag&) const = default;
    [[nodiscard]] bool is_empty() const { return leaves.empty(); }
    [[nodiscard]] bool contains(const Voxel& voxel) const;
    /// All voxels of the brick of 4 x 4 x 4 that one lies in; bit i: that of Morton code i. Outside there are none.
    [[nodiscard]] std::uint64_t brick(const Voxel& voxel) const;
    /// Of all arrays, as a file would hold them.
    [[nodiscard]] std::uint64_t byte_count() const;
};

/// A record in place, and what turns it into the node that is there.
struct PackedNode {
    std::uint64_t bit = 0;
    std::uint32_t turn = 0;
};
/// A record's first fields, read once for all of its children.
struct PackedHeader {
    std::uint64_t body_bit;   ///< Behind the classes.
    std::uint32_t child_mask; ///< By octant of the record, not of the world.
    std::uint32_t classes;    ///< 2 bits per child that is there.
};
[[nodiscard]] PackedHeader packed_header(const PackedDag& dag, std::uint32_t level, const PackedNode& node);
/// A child that is there, by octant of the record; of a node of 16^3 or more.
[[nodiscard]] PackedNode packed_child(const PackedDag& dag, std::uint32_t level, const PackedNode& node,
                                      const PackedHeader& header, std::uint32_t octant);
/// Rank of that child among the shared records of the level below; none where its record lies inside.
[[nodiscard]] std::optional<std::uint32_t> packed_rank(const PackedDag& dag, std::uint32_t level,
                                                       const PackedHeader& header, std::uint32_t octant);
/// Behind a record of 8^3.
[[nodiscard]] std::uint64_t end_of_smallest(const PackedDag& dag, std::uint64_t bit);
/// Rank of the pair that a record of 8^3 names.
[[nodiscard]] std::uint32_t packed_pair(const PackedDag& dag, const PackedHeader& header, std::uint32_t octant);
/// The leaf of a pair, and its tag.
struct PackedLeaf {
    std::uint64_t mask;
    std::uint32_t tag;
};
[[nodiscard]] PackedLeaf packed_leaf(const PackedDag& dag, std::uint32_t pair);

/// Throws InvalidInput, which names what is wrong with the tables that records are read by. Records: require_sound().
void require_usable(const PackedDag& dag);
} // namespace tyndall::voxel_dag
