// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/dag_counts.hpp"
#include <algorithm>
#include <numeric>

namespace tyndall::voxel_dag {
/// How often the nodes below are named.
static std::vector<std::uint32_t> uses_of(const DagLevel& nodes, std::size_t below_count) {
    std::vector<std::uint32_t> uses(below_count, 0);
    for (const std::uint32_t child : nodes.children)
        ++uses[child];
    return uses;
}

std::vector<LevelCounts> level_counts(const Dag& dag) {
    std::vector<LevelCounts> counts;
    if (dag.is_empty())
        return counts;
    counts.push_back({.node_count = dag.leaves.size()});
    for (const DagLevel& nodes : dag.levels) {
        const std::vector<std::uint32_t> uses = uses_of(nodes, counts.back().node_count);
        counts.back().once_count = static_cast<std::size_t>(std::ranges::count(uses, 1u));
        counts.push_back({.level = counts.back().level + 1,
                          .node_count = nodes.node_count(),
                          .reference_count = nodes.children.size()});
    }
    counts.back().once_count = 1;
    return counts;
}

std::uint64_t word_bytes(const Dag& dag) {
    std::uint64_t words = 0;
    for (std::uint64_t leaf : dag.leaves)
        for (++words; leaf != 0; leaf >>= 8)
            words += (leaf & 255) != 0;
    for (const DagLevel& nodes : dag.levels)
        words += nodes.node_count() + nodes.children.size();
    return sizeof(std::uint32_t) * words;
}

std::uint64_t half_word_bytes(const Dag& dag) {
    const std::uint64_t near_end = std::uint64_t{1} << (dag.symmetry == Symmetry::Cube ? 10 : 13);
    // Words of 16 bits per node, of the leaf's own word of 64 bits at first: an offset counts those of its level.
    std::vector<std::uint32_t> words(dag.leaves.size(), 1);
    std::uint64_t bytes = sizeof(std::uint64_t) * dag.leaves.size();
    for (const DagLevel& nodes : dag.levels) {
        const std::vector<std::uint32_t> uses = uses_of(nodes, words.size());
        std::vector<std::uint32_t> order(words.size());
        std::iota(order.begin(), order.end(), 0u);
        std::ranges::stable_sort(order, std::greater(), [&](std::uint32_t node) { return uses[node]; });
        std::vector<bool> is_near(words.size());
        std::uint64_t offset = 0;
        for (const std::uint32_t node : order) {
            is_near[node] = offset < near_end;
            offset += words[node];
        }
        words.resize(nodes.node_count());
        for (std::size_t node = 0; node < words.size(); ++node) {
            words[node] = 1;
            for (std::uint32_t i = nodes.first_children[node]; i < nodes.first_children[node + 1]; ++i)
                words[node] += is_near[nodes.children[i]] ? 1 : 2;
            bytes += 2 * words[node];
        }
    }
    return bytes;
}
} // namespace tyndall::voxel_dag
