// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/merge_symmetric.hpp"
#include "voxel_dag/canonical.hpp"
#include "voxel_dag/first_use.hpp"
#include "voxel_dag/unique_table.hpp"
#include <atomic>
#include <tbb/enumerable_thread_specific.h>

namespace tyndall::voxel_dag {
namespace {
/// Merges `count` nodes, canonical_of(plain node). Returns the merged ones in order of their numbers.
template <class Node, class CanonicalOf>
std::vector<Node> merge_level(std::size_t count, const CanonicalOf& canonical_of, std::vector<MergedNode>& merged,
                              const Progress& progress) {
    using Table = UniqueTable<Node>;
    Table table(count);
    std::vector<std::uint32_t> numbers(count);
    merged.resize(count);
    tbb::enumerable_thread_specific<typename Table::Reserve> reserves;
    std::atomic<bool> is_full = true;
    while (is_full.exchange(false)) {
        parallel_blocks(count, Table::batch_size * 128, progress, [&](std::size_t begin, std::size_t end) {
            typename Table::Reserve& reserve = reserves.local();
            for (std::size_t first = begin; first < end; first += Table::batch_size) {
                std::array<Node, Table::batch_size> batch;
                const std::size_t batched = std::min(Table::batch_size, end - first);
                for (std::size_t i = 0; i < batched; ++i) {
                    const Canonical<Node> canonical = canonical_of(first + i);
                    batch[i] = canonical.node;
                    merged[first + i] = {.number = 0, .tag = canonical.tag, .stabilizer = canonical.stabilizer};
                }
                if (!table.find_or_insert({batch.data(), batched}, &numbers[first], reserve))
                    return is_full.store(true); // of what threads took and did not need
            }
        });
        if (is_full)
            table.make_room(table.past(), progress);
    }
    const std::vector<std::uint32_t> names = number_by_first_use(numbers, table.past(), progress);
    parallel_for(
        count, progress, [&](std::size_t i) { merged[i].number = numbers[i]; }, 1 << 14);
    std::vector<Node> nodes(names.size());
    parallel_for(
        names.size(), progress, [&](std::size_t i) { nodes[i] = table[names[i]]; }, 1 << 12);
    return nodes;
}
} // namespace

std::uint64_t estimated_merge_bytes(const Dag& plain) {
    // Records twice, in the table and in order of their numbers; then the result, at most as large as the plain DAG.
    std::uint64_t most = UniqueTable<std::uint64_t>::memory_bytes(plain.leaves.size()), result = 0;
    for (const DagLevel& nodes : plain.levels) {
        most = std::max(most, UniqueTable<TurnedChildren>::memory_bytes(nodes.node_count()) +
                                  (sizeof(TurnedChildren) + 11) * nodes.node_count());
        result += 5 * nodes.node_count() + 5 * nodes.children.size();
    }
    return most + result + 8 * plain.leaves.size();
}

Dag merge_symmetric(const Dag& plain, const MergeConfig& config, const Progress& progress) {
    require(plain.symmetry == Symmetry::None && config.symmetry != Symmetry::None,
            "voxel DAG: symmetries are merged once, in a DAG that has none");
    const std::uint64_t bytes = estimated_merge_bytes(plain);
    require(bytes <= config.memory_budget_bytes, "voxel DAG: merging ", plain.node_count(), " nodes needs up to ",
            bytes >> 20, " MiB; the budget is ", config.memory_budget_bytes >> 20, " MiB");
    progress.poll();
    Dag dag{.level = plain.level, .symmetry = config.symmetry, .leaves = {}, .levels = {}};
    if (plain.is_empty())
        return dag;
    std::vector<MergedNode> below;
    dag.leaves = merge_level<std::uint64_t>(
        plain.leaves.size(), [&](std::size_t leaf) { return canonical_leaf(plain.leaves[leaf], config.symmetry); },
        below, progress);
    for (const DagLevel& nodes : plain.levels) {
        std::vector<MergedNode> merged;
        const auto canonical_of = [&](std::size_t node) {
            return canonical_node(nodes, node, config.symmetry,
                                  [&](std::size_t reference) { return below[nodes.children[reference]]; });
        };
        const auto records = merge_level<TurnedChildren>(nodes.node_count(), canonical_of, merged, progress);
        const auto record_of = [&](std::size_t node) -> const TurnedChildren& { return records[node]; };
        dag.levels.push_back(written_level(records.size(), record_of, 1, progress));
        below = std::move(merged);
    }
    dag.root_tag = below.front().tag;
    return dag;
}
} // namespace tyndall::voxel_dag
