// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/packed_dag.hpp"
#include "core/errors.hpp"
#include "voxel_dag/cube_group.hpp"
#include <algorithm>
#include <bit>

namespace tyndall::voxel_dag {
static std::uint32_t count_of(std::uint32_t bits) { return static_cast<std::uint32_t>(std::popcount(bits)); }

/// Bits of the fields of classes, 2 bits each, `count` of them.
static std::uint32_t fields_size(const std::array<std::uint32_t, 4>& field_bits, std::uint32_t classes,
                                 std::uint32_t count) {
    const std::uint32_t low = classes & 0x5555u, high = classes >> 1 & 0x5555u;
    const std::uint32_t third = count_of(low & high), first = count_of(low) - third, second = count_of(high) - third;
    return (count - first - second - third) * field_bits[0] + first * field_bits[1] + second * field_bits[2] +
           third * field_bits[3];
}

/// Of the children before one that is there.
static std::uint32_t index_of(const PackedHeader& header, std::uint32_t octant) {
    return count_of(header.child_mask & ((1u << octant) - 1));
}
static std::uint32_t first_classes(const PackedHeader& header, std::uint32_t count) {
    return header.classes & ((1u << 2 * count) - 1);
}
static std::uint32_t class_of(const PackedHeader& header, std::uint32_t index) {
    return header.classes >> 2 * index & 3;
}
/// Class 0: of those children, how many lie inside.
static std::uint32_t inside_count(std::uint32_t classes, std::uint32_t count) {
    return count - count_of((classes | classes >> 1) & 0x5555u);
}

PackedHeader packed_header(const PackedDag& dag, std::uint32_t level, const PackedNode& node) {
    const PackedLevel& format = dag.levels[level - leaf_level - 1];
    auto fields = static_cast<std::uint32_t>(read_bits(dag.records, node.bit, 26)); // 2 + 8 + 16 at most
    const std::uint32_t mask_class = fields & 3, mask_bits = format.mask_classes.widths[mask_class];
    fields >>= 2;
    const std::uint32_t mask =
        format.child_masks[(format.mask_classes.begins[mask_class] + (fields & ((1u << mask_bits) - 1))) & 0xff];
    const std::uint32_t class_bits = 2 * count_of(mask);
    return {.body_bit = node.bit + 2 + mask_bits + class_bits,
            .child_mask = mask,
            .classes = fields >> mask_bits & ((1u << class_bits) - 1)};
}

std::uint64_t end_of_smallest(const PackedDag& dag, std::uint64_t bit) {
    const PackedHeader header = packed_header(dag, leaf_level + 1, {.bit = bit});
    return header.body_bit + fields_size(dag.levels[0].field_bits, header.classes, count_of(header.child_mask));
}

static std::uint64_t shared_record(const PackedDag& dag, std::uint32_t level, std::uint32_t rank) {
    const std::uint32_t step = directory_step(level);
    std::uint64_t bit = dag.levels[level - leaf_level - 1].directory[rank / step];
    for (std::uint32_t i = rank % step; i > 0; --i)
        bit = end_of_smallest(dag, bit);
    return bit;
}

/// What the record names child number `index` by, which is shared.
struct SharedName {
    std::uint32_t rank, tag;
};
static SharedName shared_name(const PackedDag& dag, const PackedLevel& format, const PackedHeader& header,
                              std::uint32_t index) {
    const std::uint32_t at_class = class_of(header, index), width = format.classes.widths[at_class];
    const std::uint64_t bit = header.body_bit + fields_size(format.field_bits, first_classes(header, index), index);
    const std::uint64_t field = read_bits(dag.records, bit, format.field_bits[at_class]);
    const auto rank = static_cast<std::uint32_t>(field & ((std::uint64_t{1} << width) - 1));
    return {.rank = format.classes.begins[at_class] + rank, .tag = format.tags[field >> width & 63]};
}

std::optional<std::uint32_t> packed_rank(const PackedDag& dag, std::uint32_t level, const PackedHeader& header,
                                         std::uint32_t octant) {
    const std::uint32_t index = index_of(header, octant);
    if (class_of(header, index) == 0)
        return std::nullopt;
    return shared_name(dag, dag.levels[level - leaf_level - 1], header, index).rank;
}

PackedNode packed_child(const PackedDag& dag, std::uint32_t level, const PackedNode& node, const PackedHeader& header,
                        std::uint32_t octant) {
    const PackedLevel& format = dag.levels[level - leaf_level - 1];
    const std::uint32_t index = index_of(header, octant);
    if (class_of(header, index) != 0) {
        const SharedName name = shared_name(dag, format, header, index);
        return {.bit = shared_record(dag, level - 1, name.rank), .turn = cube_group.product[node.turn][name.tag]};
    }
    const std::uint32_t before = first_classes(header, index);
    const std::uint32_t child_count = count_of(header.child_mask);
    const std::uint64_t tag_bit = header.body_bit + fields_size(format.field_bits, before, index);
    const std::uint32_t tag = format.tags[read_bits(dag.records, tag_bit, format.field_bits[0]) & 63];
    const std::uint32_t turn = cube_group.product[node.turn][tag];
    std::uint64_t bit = header.body_bit + fields_size(format.field_bits, header.classes, child_count);
    std::uint32_t skipped = inside_count(before, index);
    if (level == leaf_level + 2) {
        for (; skipped > 0; --skipped)
            bit = end_of_smallest(dag, bit);
        return {.bit = bit, .turn = turn};
    }
    const std::uint32_t inside = inside_count(header.classes, child_count);
    if (inside > 1) {
        const auto width = static_cast<std::uint32_t>(read_bits(dag.records, bit, 5));
        std::uint64_t length_bit = bit + 5;
        bit = length_bit + std::uint64_t{inside - 1} * width;
        for (; skipped > 0; --skipped, length_bit += width)
            bit += read_bits(dag.records, length_bit, width);
    }
    return {.bit = bit, .turn = turn};
}

std::uint32_t packed_pair(const PackedDag& dag, const PackedHeader& header, std::uint32_t octant) {
    const PackedLevel& format = dag.levels[0];
    const std::uint32_t index = index_of(header, octant), at_class = class_of(header, index);
    const std::uint64_t bit = header.body_bit + fields_size(format.field_bits, first_classes(header, index), index);
    return format.classes.begins[at_class] +
           static_cast<std::uint32_t>(read_bits(dag.records, bit, format.field_bits[at_class]));
}

PackedLeaf packed_leaf(const PackedDag& dag, std::uint32_t pair) {
    const std::uint32_t width = dag.leaf_bits + dag.tag_bits;
    const std::uint64_t field = read_bits(dag.pairs, std::uint64_t{pair} * width, width);
    return {.mask = dag.leaves[field & ((std::uint64_t{1} << dag.leaf_bits) - 1)],
            .tag = static_cast<std::uint32_t>(field >> dag.leaf_bits)};
}

/// The brick that a voxel lies in, as it is stored, and what turns it into what is there; without voxels, 0.
struct StoredBrick {
    std::uint64_t mask;
    std::uint32_t turn;
};
static StoredBrick stored_brick(const PackedDag& dag, const Voxel& voxel, std::uint64_t code) {
    if (dag.is_empty() || std::ranges::any_of(voxel, [&](std::uint32_t at) { return at >> dag.level != 0; }))
        return {};
    PackedNode node{.bit = dag.root_bit};
    std::uint32_t pair = 0;
    for (std::uint32_t at = dag.level; at > leaf_level; --at) {
        const auto there = static_cast<std::uint32_t>(code >> 3 * (at - 1) & 7);
        const std::uint32_t octant = cube_group.octant[cube_group.inverse[node.turn]][there];
        const PackedHeader header = packed_header(dag, at, node);
        if ((header.child_mask >> octant & 1) == 0)
            return {};
        if (at == leaf_level + 1)
            pair = packed_pair(dag, header, octant);
        else
            node = packed_child(dag, at, node, header, octant);
    }
    const PackedLeaf leaf = packed_leaf(dag, pair);
    return {.mask = leaf.mask, .turn = cube_group.product[node.turn][leaf.tag]};
}

bool PackedDag::contains(const Voxel& voxel) const {
    const std::uint64_t code = morton_code(voxel);
    const auto [mask, turn] = stored_brick(*this, voxel, code);
    return (mask >> turned_voxel(cube_group.inverse[turn], static_cast<std::uint32_t>(code & 63)) & 1) != 0;
}
std::uint64_t PackedDag::brick(const Voxel& voxel) const {
    const auto [mask, turn] = stored_brick(*this, voxel, morton_code(voxel));
    return turned_leaf(turn, mask);
}

std::uint64_t PackedDag::byte_count() const {
    std::uint64_t bytes = 8 * (leaves.size() + pairs.size() + records.size()) + 24;
    for (const PackedLevel& format : levels)
        bytes += 4 * (format.directory.size() + 20) + format.child_masks.size() + format.tags.size();
    return bytes;
}

void require_usable(const PackedDag& dag) {
    require(leaf_level <= dag.level && dag.level <= most_level, "voxel DAG: 2^", dag.level, " a side; from 2^",
            leaf_level, " to 2^", most_level, " are possible");
    require(dag.tag_bits == 0 || dag.tag_bits == 3 || dag.tag_bits == 6, "voxel DAG: tags of ", dag.tag_bits, " bits");
    require(dag.leaf_bits <= 32, "voxel DAG: numbers of leaves of ", dag.leaf_bits, " bits");
    if (dag.is_empty())
        return;
    require(dag.levels.size() == dag.level - leaf_level, "voxel DAG: ", dag.levels.size(), " levels of nodes in 2^",
            dag.level, " voxels a side");
    constexpr std::uint64_t slack_bits = 64; // behind the last bit that is read
    require(64 * dag.pairs.size() >= dag.leaf_bits + dag.tag_bits + slack_bits, "voxel DAG: no leaf has a name");
    const std::uint64_t record_bits = 64 * dag.records.size();
    require(dag.level == leaf_level || (slack_bits <= record_bits && dag.root_bit < record_bits - slack_bits),
            "voxel DAG: the root's record is not there");
    for (std::size_t i = 0; i < dag.levels.size(); ++i) {
        const PackedLevel& level = dag.levels[i];
        for (std::size_t at_class = 0; at_class < 4; ++at_class)
            require(level.mask_classes.widths[at_class] <= 8 && level.classes.widths[at_class] <= 32 &&
                        level.classes.widths[at_class] <= level.field_bits[at_class] &&
                        level.field_bits[at_class] <= level.classes.widths[at_class] + dag.tag_bits,
                    "voxel DAG: fields of ", level.field_bits[at_class], " bits in level ", i + leaf_level + 1);
        require(i == 0 || level.field_bits[0] <= dag.tag_bits, "voxel DAG: tags of ", level.field_bits[0],
                " bits in level ", i + leaf_level + 1);
        require(std::ranges::all_of(level.tags, [](std::uint8_t tag) { return tag < cube_element_count; }),
                "voxel DAG: a tag in level ", i + leaf_level + 1, " is none of the cube's");
        require(std::ranges::all_of(level.directory, [&](std::uint32_t bit) { return bit < record_bits - slack_bits; }),
                "voxel DAG: the directory of level ", i + leaf_level + 1, " leaves the records");
    }
}
} // namespace tyndall::voxel_dag
