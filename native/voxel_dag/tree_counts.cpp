// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/tree_counts.hpp"
#include "voxel_dag/tree_nodes.hpp"
#include <algorithm>
#include <bit>

namespace tyndall::voxel_dag {
/// A record, or of leaves a pair, and how often the tree has it.
struct Occurring {
    std::uint64_t bit, count;
};

static void merge_equal(std::vector<Occurring>& nodes) {
    std::ranges::sort(nodes, {}, &Occurring::bit);
    std::size_t kept = 0;
    for (const Occurring& node : nodes)
        if (kept > 0 && nodes[kept - 1].bit == node.bit)
            nodes[kept - 1].count += node.count;
        else
            nodes[kept++] = node;
    nodes.resize(kept);
}

static std::uint64_t total(const std::vector<Occurring>& nodes) {
    std::uint64_t sum = 0;
    for (const Occurring& node : nodes)
        sum += node.count;
    return sum;
}

/// Of 2 x 2 x 2 voxels, those that are not empty.
static std::uint64_t bytes_set(std::uint64_t mask) {
    std::uint64_t bytes = 0;
    for (; mask != 0; mask >>= 8)
        bytes += (mask & 0xff) != 0;
    return bytes;
}

std::vector<TreeCounts> tree_counts(const PackedDag& dag, const Progress& progress) {
    std::vector<TreeCounts> counts;
    if (dag.is_empty())
        return counts;
    std::vector<Occurring> nodes{{.bit = dag.root_bit, .count = 1}}, below;
    for (std::uint32_t level = dag.level; level > leaf_level; --level) {
        counts.push_back({.level = level, .node_count = nodes.size(), .tree_count = total(nodes)});
        below.clear();
        constexpr std::size_t polled = 1 << 16;
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            if (i % polled == 0)
                progress.poll();
            const PackedNode node{.bit = nodes[i].bit};
            const PackedHeader header = packed_header(dag, level, node);
            for (std::uint32_t left = header.child_mask; left != 0; left &= left - 1) {
                const auto octant = static_cast<std::uint32_t>(std::countr_zero(left));
                below.push_back({.bit = child_of(dag, level, node, header, octant).bit, .count = nodes[i].count});
            }
        }
        merge_equal(below);
        std::swap(nodes, below);
    }
    std::uint64_t smallest = 0;
    for (const Occurring& pair : nodes)
        smallest += pair.count * bytes_set(packed_leaf(dag, static_cast<std::uint32_t>(pair.bit)).mask);
    // Several pairs name one leaf, each turned its own way.
    counts.push_back({.level = leaf_level, .node_count = dag.leaves.size(), .tree_count = total(nodes)});
    counts.push_back({.level = 1, .node_count = 0, .tree_count = smallest});
    std::ranges::reverse(counts);
    return counts;
}

std::array<PartBytes, 4> bytes_by_part(const PackedDag& dag) {
    std::uint64_t directories = 0;
    for (const PackedLevel& format : dag.levels)
        directories += sizeof(std::uint32_t) * format.directory.size();
    const std::uint64_t leaves = 8 * dag.leaves.size(), pairs = 8 * dag.pairs.size();
    const std::uint64_t rest = dag.byte_count() - leaves - pairs - directories;
    return {{{"leaves", leaves}, {"pairs", pairs}, {"records", rest}, {"directories", directories}}};
}
} // namespace tyndall::voxel_dag
