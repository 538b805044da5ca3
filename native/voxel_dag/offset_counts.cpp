// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/offset_counts.hpp"
#include "core/errors.hpp"
#include <algorithm>
#include <array>
#include <span>

namespace tyndall::voxel_dag {
OffsetLayout OffsetLayout::combined() {
    return {.has_implicit_first = true,
            .has_offset_bytes = true,
            .has_pointer_bytes = true,
            .has_byte_masks = true,
            .has_pointers_by_use = true};
}

namespace {
/// Of numbers up to `largest`.
std::uint64_t bytes_for(std::uint64_t largest) {
    return std::max<std::uint64_t>(1, (static_cast<std::uint64_t>(std::bit_width(largest)) + 7) / 8);
}

/// Of pointers in 1 to 3 bytes, the most used first, where a table entry of 4 is worth it, else in 4: 2.4.4.
std::uint64_t bytes_by_use(std::vector<std::uint64_t> uses) {
    constexpr std::uint64_t entry_bytes = 4, most_bytes = 4;
    std::ranges::sort(uses, std::greater());
    std::uint64_t bytes = 0;
    for (std::size_t rank = 0; rank < uses.size(); ++rank) {
        const std::uint64_t width = rank < 1u << 6 ? 1 : rank < 1u << 14 ? 2 : rank < 1u << 22 ? 3 : most_bytes;
        bytes += std::min(uses[rank] * most_bytes, uses[rank] * width + entry_bytes);
    }
    return bytes;
}

/// From the lowest level up.
class Counter {
public:
    Counter(const OffsetLayout& layout, std::span<const std::uint8_t> lowest_masks) : layout_(layout) {
        for (const std::uint8_t mask : lowest_masks)
            tree_nodes_.push_back(1 + static_cast<std::uint64_t>(std::popcount(mask)));
        level_bytes_ = bytes_ = mask_bytes() * lowest_masks.size();
    }
    /// Node i has the children [first_children[i], first_children[i + 1]), numbers of the level before.
    void add_level(std::span<const std::uint32_t> first_children, std::span<const std::uint32_t> children) {
        std::vector<std::uint64_t> tree_nodes, uses(tree_nodes_.size());
        std::uint64_t largest_offset = 0;
        for (std::size_t node = 0; node + 1 < first_children.size(); ++node) {
            std::uint64_t offset = 1;
            for (std::uint32_t i = first_children[node]; i < first_children[node + 1]; ++i) {
                largest_offset = std::max(largest_offset, offset);
                offset += tree_nodes_[children[i]];
                ++uses[children[i]];
            }
            tree_nodes.push_back(offset);
        }
        const std::uint64_t node_count = tree_nodes.size();
        const std::uint64_t pointer_width = layout_.has_pointer_bytes ? bytes_for(level_bytes_) : 4;
        const std::uint64_t offset_width = layout_.has_offset_bytes
                                               ? bytes_for(largest_offset)
                                               : std::max<std::uint64_t>(4, bytes_for(largest_offset));
        const std::uint64_t offset_count =
            layout_.has_offsets ? children.size() - (layout_.has_implicit_first ? node_count : 0) : 0;
        level_bytes_ = mask_bytes() * node_count + offset_width * offset_count +
                       (layout_.has_pointers_by_use ? bytes_by_use(std::move(uses)) : pointer_width * children.size());
        bytes_ += level_bytes_;
        tree_nodes_ = std::move(tree_nodes);
    }
    [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

private:
    [[nodiscard]] std::uint64_t mask_bytes() const { return layout_.has_byte_masks ? 1 : 4; }

    OffsetLayout layout_;
    std::vector<std::uint64_t> tree_nodes_; // of what each node of the last level stands for
    std::uint64_t level_bytes_ = 0, bytes_ = 0;
};
} // namespace

std::uint64_t offset_dag_bytes(const Dag& dag, const OffsetLayout& layout) {
    require(dag.symmetry == Symmetry::None, "offset DAG: references have tags, which offsets cannot follow");
    if (dag.is_empty())
        return 0;
    std::array<bool, 256> is_there{};
    for (std::uint64_t leaf : dag.leaves)
        for (; leaf != 0; leaf >>= 8)
            is_there[leaf & 255] = true;
    std::vector<std::uint8_t> masks;
    std::array<std::uint32_t, 256> number_of{};
    for (std::uint32_t mask = 1; mask < 256; ++mask)
        if (is_there[mask]) {
            number_of[mask] = static_cast<std::uint32_t>(masks.size());
            masks.push_back(static_cast<std::uint8_t>(mask));
        }
    std::vector<std::uint32_t> first_children{0}, children;
    for (std::uint64_t leaf : dag.leaves) {
        for (; leaf != 0; leaf >>= 8)
            if ((leaf & 255) != 0)
                children.push_back(number_of[leaf & 255]);
        first_children.push_back(static_cast<std::uint32_t>(children.size()));
    }
    Counter counter(layout, masks);
    counter.add_level(first_children, children);
    for (const DagLevel& nodes : dag.levels)
        counter.add_level(nodes.first_children, nodes.children);
    return counter.bytes();
}
} // namespace tyndall::voxel_dag
