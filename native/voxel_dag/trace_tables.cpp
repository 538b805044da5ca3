// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/trace_tables.hpp"
#include <algorithm>
#include <bit>

namespace tyndall::voxel_dag {
constinit const OrderedMasks ordered_masks;

static constexpr ViewTable make_views() {
    ViewTable views{};
    for (std::uint32_t against = 0; against < 8; ++against)
        for (std::uint32_t turn = 0; turn < cube_element_count; ++turn)
            views[against][turn] = cube_group.product[cube_group.inverse[turn]][against];
    return views;
}
constinit const ViewTable view_of = make_views();

RecordTable make_record_table(const PackedLevel& level) {
    RecordTable table{.heads = {},
                      .sizes = {},
                      .field_bits = level.field_bits,
                      .rank_bits = level.classes.widths,
                      .tag_bits = {},
                      .begins = level.classes.begins,
                      .tags = level.tags,
                      .directory = level.directory.data()};
    for (std::size_t at_class = 0; at_class < 4; ++at_class)
        table.tag_bits[at_class] = level.field_bits[at_class] - level.classes.widths[at_class];
    for (std::uint32_t bits = 0; bits < table.heads.size(); ++bits) {
        const std::uint32_t mask_class = bits & 3, width = level.mask_classes.widths[mask_class];
        const std::uint32_t rank = level.mask_classes.begins[mask_class] + (bits >> 2 & ((1u << width) - 1));
        table.heads[bits] = static_cast<std::uint16_t>(level.child_masks[rank & 0xff] | (2 + width) << 8);
    }
    for (std::uint32_t classes = 0; classes < table.sizes.size(); ++classes)
        for (std::uint32_t child = 0; child < 4; ++child)
            table.sizes[classes] =
                static_cast<std::uint8_t>(table.sizes[classes] + level.field_bits[classes >> 2 * child & 3]);
    return table;
}

/// The places of all shared records of 8^3. Behind the last one are places of no record, which nothing names.
static std::vector<std::uint64_t> smallest_places(const PackedDag& dag) {
    std::vector<std::uint64_t> places;
    const std::uint64_t past = 64 * dag.records.size() - 64;
    for (const std::uint32_t first : dag.levels[0].directory) {
        std::uint64_t place = first, bit = first;
        for (std::uint32_t i = 1; i < directory_step(leaf_level + 1); ++i) {
            bit = bit < past ? end_of_smallest(dag, bit) : bit;
            place |= (bit - first) << (32 + distance_bits * (i - 1));
        }
        places.push_back(place);
    }
    return places;
}

/// The children of a node of 16^3 or more, in the order of their octants in the world; returns the mask of these.
static std::uint32_t add_children(const PackedDag& dag, std::uint32_t level, const PackedNode& node,
                                  std::vector<PackedNode>& children) {
    const PackedHeader header = packed_header(dag, level, node);
    const auto& octants = cube_group.octant[cube_group.inverse[node.turn]];
    std::uint32_t mask = 0;
    for (std::uint32_t there = 0; there < 8; ++there)
        if ((header.child_mask >> octants[there] & 1) != 0) {
            mask |= 1u << there;
            children.push_back(packed_child(dag, level, node, header, octants[there]));
        }
    return mask;
}

static void add_top(TraceTables& tables, std::size_t most_top_nodes) {
    const PackedDag& dag = *tables.dag;
    std::vector<PackedNode> nodes{{.bit = dag.root_bit}}, below;
    std::vector<TopNode> inner;
    for (tables.bottom = dag.level; tables.bottom > leaf_level + 1; --tables.bottom) {
        below.clear(), inner.clear();
        for (const PackedNode& node : nodes) {
            const std::uint64_t first = tables.top.size() + nodes.size() + below.size();
            inner.push_back(add_children(dag, tables.bottom, node, below) | first << 8);
            if (tables.top.size() + nodes.size() + below.size() > most_top_nodes)
                break;
        }
        if (tables.top.size() + nodes.size() + below.size() > most_top_nodes)
            break;
        tables.top.insert(tables.top.end(), inner.begin(), inner.end());
        nodes.swap(below);
    }
    for (const PackedNode& node : nodes)
        tables.top.push_back(node.turn | node.bit << 6);
}

TraceTables make_trace_tables(const PackedDag& dag, std::size_t most_top_nodes) {
    TraceTables tables{.dag = &dag, .top = {}, .levels = {}, .smallest = {}};
    if (dag.is_empty() || dag.level == leaf_level) // no records
        return tables;
    add_top(tables, most_top_nodes);
    for (std::uint32_t level = leaf_level + 1; level <= tables.bottom; ++level)
        tables.levels.push_back(make_record_table(dag.levels[level - leaf_level - 1]));
    tables.smallest = smallest_places(dag);
    return tables;
}

std::uint64_t byte_count(const TraceTables& tables) {
    return sizeof(ordered_masks) + sizeof(view_of) + 8 * (tables.top.size() + tables.smallest.size()) +
           sizeof(RecordTable) * tables.levels.size();
}
} // namespace tyndall::voxel_dag
