// SPDX-License-Identifier: GPL-3.0-or-later
// What a Tracer keeps beside a packed DAG, so that a step down takes few dependent loads.
// Differs:  from packed_dag.hpp in no result. The topmost levels are nodes of their own, turned as the world is, so that
//           neither records nor turns are read there; headers and lengths of fields come from tables by their bits; each
//           shared record of 8^3 has its place, not every fourth.
// Bound:    8 bytes per topmost node; 2 per shared record of 8^3; 2.4 KB per level; 12 KB for all DAGs.
#pragma once
#include "voxel_dag/cube_group.hpp"
#include "voxel_dag/packed_dag.hpp"

namespace tyndall::voxel_dag {
/// Masks of octants as an element's table of octants orders them: bit i of of[h][mask] is bit octant[h][i] of mask.
struct OrderedMasks {
    std::array<std::array<std::uint8_t, 256>, cube_element_count> of;

    constexpr OrderedMasks() : of{} {
        for (std::uint32_t h = 0; h < cube_element_count; ++h)
            for (std::uint32_t mask = 1; mask < 256; ++mask) {
                const auto highest = static_cast<std::uint32_t>(std::bit_width(mask)) - 1;
                const std::uint32_t there = cube_group.octant[cube_group.inverse[h]][highest];
                of[h][mask] = static_cast<std::uint8_t>(of[h][mask ^ 1u << highest] | 1u << there);
            }
    }
};
extern const OrderedMasks ordered_masks;

/// By the axes along which a ray goes down, and a node's turn: the element whose table of octants leads from those counted
/// along the ray to stored ones.
using ViewTable = std::array<std::array<std::uint8_t, cube_element_count>, 8>;
extern const ViewTable view_of;

/// How the records of one level are read.
struct RecordTable {
    std::array<std::uint16_t, 1024>
        heads; ///< By a record's first 10 bits: its child mask, and 256 * bits before classes.
    std::array<std::uint8_t, 256> sizes; ///< By the classes of four children: bits of their fields.
    std::array<std::uint32_t, 4> field_bits, rank_bits, tag_bits, begins; ///< By class.
    std::array<std::uint8_t, 64> tags;                                    ///< By rank.
    const std::uint32_t* directory;                                       ///< Of this level's shared records.
};

[[nodiscard]] RecordTable make_record_table(const PackedLevel& level);

/// A node of the topmost levels. Inner ones: the child mask, by octants of the world, and 256 * the first child's place.
/// Of the last of these levels: the turn, and 64 * the record's bit.
using TopNode = std::uint64_t;

struct TraceTables {
    const PackedDag* dag = nullptr;
    std::uint32_t bottom = leaf_level;   ///< The level of records that topmost nodes lead to.
    std::vector<TopNode> top;            ///< Level by level, the root first; children in the order of their octants.
    std::vector<RecordTable> levels;     ///< levels[i]: 2^(3 + i) voxels a side, up to bottom.
    std::vector<std::uint64_t> smallest; ///< Per 4 shared records of 8^3: the first one's bit, and 3 distances to it.
};
inline constexpr std::uint32_t distance_bits = 10; ///< Of such a distance: three records of at most 282 bits.
static_assert(3 * (2 + 8 + 16 + 8 * 32) < 1 << distance_bits && directory_step(leaf_level + 1) == 4);

/// Of all of these.
[[nodiscard]] std::uint64_t byte_count(const TraceTables& tables);
/// With at most so many topmost nodes, the root at least. The DAG must outlive them.
[[nodiscard]] TraceTables make_trace_tables(const PackedDag& dag, std::size_t most_top_nodes);
} // namespace tyndall::voxel_dag
