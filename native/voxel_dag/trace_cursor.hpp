// SPDX-License-Identifier: GPL-3.0-or-later
// One place in a packed DAG, and the way down from there by the tables of trace_tables.hpp.
// Based on: Jaspe, dissertation 2018, 5.5.1, "transforming the geometry": octants are turned, rays stay.
// Differs:  octants are counted along the ray: bit a is set behind the middle plane of axis a. One element of the cube's
//           symmetries, the node's turn and the ray's direction together, leads from these to the stored ones, and orders
//           the stored mask.
// Bound:    4 to 6 dependent loads per step.
#pragma once
#include "voxel_dag/trace_tables.hpp"
#include <bit>
#include <cstring>
#include <hwy/base.h>

namespace tyndall::voxel_dag {
/// A cube that was opened.
struct CursorNode {
    std::uint64_t place;               ///< Its first child in the topmost nodes; its record's body; its brick.
    std::uint32_t child_mask, classes; ///< As stored.
    std::uint32_t turn, view;          ///< view: the element that leads from octants along the ray to stored ones.
};

class Cursor {
public:
    /// At the root, for rays that go down along the axes whose bits are set.
    HWY_INLINE void start(const TraceTables& tables, std::uint32_t against) {
        tables_ = &tables;
        records_ = tables.dag->records.data();
        against_ = against;
        level_ = tables.dag->level;
        place_ = 0, turn_ = 0;
        if (level_ == leaf_level)
            go_to_leaf(0);
        else if (level_ == tables.bottom)
            go_to_record(tables.top[0]);
    }
    [[nodiscard]] HWY_INLINE std::uint32_t level() const { return level_; }
    /// In the topmost nodes, a record's bit, a leaf's number, a leaf's byte; what turns the last three into what is there.
    [[nodiscard]] HWY_INLINE std::uint64_t place() const { return place_; }
    [[nodiscard]] HWY_INLINE std::uint32_t turn() const { return turn_; }
    [[nodiscard]] HWY_INLINE std::uint32_t against() const { return against_; }
    [[nodiscard]] HWY_INLINE const TraceTables* tables() const { return tables_; }

    /// The mask of its children along the ray.
    HWY_INLINE std::uint32_t open(CursorNode& node) const {
        if (level_ > tables_->bottom) {
            const TopNode top = tables_->top[place_];
            node.place = top >> 8;
            return set_mask(node, top & 0xff, 0);
        }
        if (level_ > leaf_level) {
            const Record record = record_at(table_of(level_), place_);
            node.place = record.body;
            node.classes = record.classes;
            return set_mask(node, record.child_mask, turn_);
        }
        node.place = place_;
        if (level_ == leaf_level) {
            node.place = tables_->dag->leaves[place_];
            return set_mask(node, occupied_bytes(node.place), turn_);
        }
        return set_mask(node, static_cast<std::uint32_t>(place_), turn_);
    }

    /// To a child that is there, of the node that was opened last on this level; by octant along the ray.
    HWY_INLINE void go_down(std::uint32_t level, const CursorNode& node, std::uint32_t along) {
        level_ = level - 1;
        turn_ = node.turn;
        const std::uint32_t octant = cube_group.octant[node.view][along];
        if (level == leaf_level) {
            place_ = node.place >> 8 * octant & 0xff;
            return;
        }
        const std::uint32_t index = count_of(node.child_mask & ((1u << octant) - 1));
        if (level > tables_->bottom) {
            place_ = node.place + index;
            if (level_ == tables_->bottom)
                go_to_record(tables_->top[place_]);
            else
                __builtin_prefetch(&tables_->top[place_]);
            return;
        }
        const RecordTable& table = table_of(level);
        const std::uint32_t before = low(node.classes, 2 * index), at_class = node.classes >> 2 * index & 3;
        const std::uint64_t bit = node.place + size_of(table, before, index);
        if (level == leaf_level + 1) {
            go_to_leaf(table.begins[at_class] + low(bits_at(records_, bit), table.field_bits[at_class]));
        } else if (at_class != 0) {
            const std::uint64_t field = bits_at(records_, bit);
            const std::uint32_t width = table.rank_bits[at_class];
            turn_ = cube_group.product[turn_][table.tags[low(field >> width, table.tag_bits[at_class])]];
            go_to_shared(table.begins[at_class] + low(field, width));
        } else {
            turn_ = cube_group.product[turn_][table.tags[low(bits_at(records_, bit), table.field_bits[0])]];
            go_inside(level, node, index - count_of((before | before >> 1) & 0x5555u));
        }
    }

private:
    /// What is read once of a record.
    struct Record {
        std::uint64_t body;
        std::uint32_t child_mask, classes;
    };
    static HWY_INLINE std::uint64_t bits_at(const std::uint64_t* words, std::uint64_t bit) {
        std::uint64_t loaded;
        std::memcpy(&loaded, reinterpret_cast<const unsigned char*>(words) + bit / 8, sizeof(loaded));
        return loaded >> bit % 8;
    }
    static HWY_INLINE std::uint32_t low(std::uint64_t bits, std::uint32_t width) {
        return static_cast<std::uint32_t>(bits & ((std::uint64_t{1} << width) - 1));
    }
    static HWY_INLINE std::uint32_t count_of(std::uint32_t bits) {
        return static_cast<std::uint32_t>(std::popcount(bits));
    }
    [[nodiscard]] HWY_INLINE const RecordTable& table_of(std::uint32_t level) const {
        return tables_->levels[level - leaf_level - 1];
    }
    [[nodiscard]] HWY_INLINE Record record_at(const RecordTable& table, std::uint64_t bit) const {
        const std::uint64_t bits = bits_at(records_, bit);
        const std::uint32_t head = table.heads[bits & 1023], mask = head & 0xff, class_bits = 2 * count_of(mask);
        return {.body = bit + (head >> 8) + class_bits,
                .child_mask = mask,
                .classes = low(bits >> (head >> 8), class_bits)};
    }
    /// Bits of the fields of the first `count` children, whose classes these are.
    static HWY_INLINE std::uint32_t size_of(const RecordTable& table, std::uint32_t classes, std::uint32_t count) {
        // Behind the last one classes are 0, which counts them.
        return table.sizes[classes & 0xff] + table.sizes[classes >> 8] - (8 - count) * table.field_bits[0];
    }
    HWY_INLINE std::uint32_t set_mask(CursorNode& node, std::uint32_t child_mask, std::uint32_t turn) const {
        node.turn = turn;
        node.child_mask = child_mask;
        node.view = view_of[against_][turn];
        return ordered_masks.of[node.view][child_mask];
    }
    HWY_INLINE void prefetch_record() const {
        __builtin_prefetch(reinterpret_cast<const unsigned char*>(records_) + place_ / 8);
    }
    HWY_INLINE void go_to_record(TopNode node) {
        turn_ = node & 63;
        place_ = node >> 6;
        prefetch_record();
    }
    HWY_INLINE void go_to_leaf(std::uint32_t pair) {
        const PackedDag& dag = *tables_->dag;
        const std::uint64_t field = bits_at(dag.pairs.data(), std::uint64_t{pair} * (dag.leaf_bits + dag.tag_bits));
        place_ = low(field, dag.leaf_bits);
        turn_ = cube_group.product[turn_][low(field >> dag.leaf_bits, dag.tag_bits)];
        __builtin_prefetch(&dag.leaves[place_]);
    }
    HWY_INLINE void go_to_shared(std::uint32_t rank) {
        if (level_ == leaf_level + 1) {
            const std::uint64_t four = tables_->smallest[rank / 4];
            const std::uint32_t in_four = rank % 4;
            place_ = low(four, 32) +
                     (in_four == 0 ? 0 : low(four >> (32 - distance_bits + distance_bits * in_four), distance_bits));
        } else {
            place_ = table_of(level_).directory[rank];
        }
        prefetch_record();
    }
    /// To a record inside another, behind `skipped` ones.
    HWY_INLINE void go_inside(std::uint32_t level, const CursorNode& node, std::uint32_t skipped) {
        const std::uint32_t child_count = count_of(node.child_mask);
        place_ = node.place + size_of(table_of(level), node.classes, child_count);
        if (level == leaf_level + 2) {
            for (; skipped > 0; --skipped) {
                const Record record = record_at(table_of(level_), place_);
                place_ = record.body + size_of(table_of(level_), record.classes, count_of(record.child_mask));
            }
            return;
        }
        const std::uint32_t inside = child_count - count_of((node.classes | node.classes >> 1) & 0x5555u);
        if (inside > 1) {
            const std::uint32_t width = low(bits_at(records_, place_), 5);
            std::uint64_t length = place_ + 5;
            place_ = length + std::uint64_t{inside - 1} * width;
            for (; skipped > 0; --skipped, length += width)
                place_ += low(bits_at(records_, length), width);
        }
        prefetch_record();
    }

    const TraceTables* tables_;
    const std::uint64_t* records_;
    std::uint64_t place_; ///< In the topmost nodes, a bit, a leaf's number, a leaf's byte.
    std::uint32_t turn_, level_, against_;
};
} // namespace tyndall::voxel_dag
