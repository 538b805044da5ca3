// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/dag_counts.hpp"
#include <algorithm>

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
} // namespace tyndall::voxel_dag
