// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/build_dag.hpp"
#include "voxel_dag/first_use.hpp"
#include "voxel_dag/unique_table.hpp"
#include "voxel_dag/write_level.hpp"
#include <algorithm>
#include <deque>
#include <tbb/enumerable_thread_specific.h>

namespace tyndall::voxel_dag {
namespace {
using LeafTable = UniqueTable<std::uint64_t>;
using NodeTable = UniqueTable<Children>;
constexpr std::size_t block_bricks = 1 << 15; ///< About what a thread takes at a time: its row fits the second cache.

/// Of a surface: of 30 leaves 1 is distinct, and of its nodes nearly all but those of 8^3, 3 of 4.
std::size_t expected_leaves(std::size_t brick_count) { return brick_count / 32; }
std::size_t expected_nodes(std::size_t brick_count, std::uint32_t level) {
    return level == leaf_level + 1 ? brick_count / 16 * 3 : brick_count >> 2 * (level - leaf_level);
}

/// Nodes of one level in Morton order: their codes and their numbers.
struct Row {
    std::vector<std::uint64_t> codes;
    std::vector<std::uint32_t> numbers;
};
/// What a thread keeps from block to block.
struct Scratch {
    Row row;
    LeafTable::Reserve leaves;
    std::array<NodeTable::Reserve, most_level + 1> nodes;
};

class Reduction {
public:
    Reduction(const LeafMasks& voxels, const BuildConfig& config, const Progress& progress)
        : voxels_(voxels), config_(config), progress_(progress), leaves_(expected_leaves(voxels.codes.size())) {
        for (std::uint32_t level = leaf_level + 1; level <= voxels.level; ++level)
            nodes_.emplace_back(expected_nodes(voxels.codes.size(), level));
    }

    Dag run() {
        const std::uint32_t top = voxels_.level;
        // Blocks end where subtrees of this level do: a few thousand in a surface, whatever its resolution.
        const std::uint32_t cut = std::min(top, std::max(std::uint32_t{6}, top - std::min(top, std::uint32_t{6})));
        Row row = reduce_blocks(cut);
        if (is_refused_)
            require_usable(voxels_);
        Scratch& scratch = scratches_.local();
        for (std::uint32_t level = cut + 1; level <= top; ++level) {
            make_room(table(level), row.codes.size());
            climb(row, level, scratch);
        }
        return number_from_root(row.numbers.front());
    }

private:
    NodeTable& table(std::uint32_t level) { return nodes_[level - leaf_level - 1]; }

    Row reduce_blocks(std::uint32_t cut) {
        const std::vector<std::size_t> ends = block_ends(cut);
        std::vector<Row> rows(ends.size());
        for (std::vector<std::uint8_t> is_done(ends.size(), 0); std::ranges::find(is_done, 0) != is_done.end();) {
            parallel_for(
                ends.size(), progress_,
                [&](std::size_t block) {
                    Scratch& scratch = scratches_.local();
                    if (is_done[block] || is_refused_ ||
                        !reduce(block ? ends[block - 1] : 0, ends[block], cut, scratch))
                        return;
                    rows[block] = scratch.row;
                    is_done[block] = true;
                },
                1);
            if (is_refused_)
                return {};
            // A table was too small for some blocks: they go once more, and find what they have brought already.
            if (leaves_.is_full())
                make_room(leaves_, leaves_.past());
            for (NodeTable& nodes : nodes_)
                if (nodes.is_full())
                    make_room(nodes, nodes.past());
        }
        Row all;
        for (const Row& row : rows) {
            all.codes.insert(all.codes.end(), row.codes.begin(), row.codes.end());
            all.numbers.insert(all.numbers.end(), row.numbers.begin(), row.numbers.end());
        }
        return all;
    }

    std::vector<std::size_t> block_ends(std::uint32_t cut) const {
        const std::vector<std::uint64_t>& codes = voxels_.codes;
        const std::uint32_t digits = 3 * (cut - leaf_level);
        std::vector<std::size_t> ends;
        for (std::size_t end = 0; end < codes.size(); ends.push_back(end)) {
            const std::size_t last = std::min(end + block_bricks, codes.size()) - 1;
            const std::uint64_t next_subtree = ((codes[last] >> digits) + 1) << digits;
            const auto begin = codes.begin() + static_cast<std::ptrdiff_t>(last) + 1;
            end = static_cast<std::size_t>(std::lower_bound(begin, codes.end(), next_subtree) - codes.begin());
        }
        return ends;
    }

    /// Bricks of whole subtrees, up to the roots of those. False where a table is full.
    bool reduce(std::size_t begin, std::size_t end, std::uint32_t cut, Scratch& scratch) {
        Row& row = scratch.row;
        row.codes.assign(voxels_.codes.begin() + static_cast<std::ptrdiff_t>(begin),
                         voxels_.codes.begin() + static_cast<std::ptrdiff_t>(end));
        row.numbers.resize(end - begin);
        if (!are_usable(begin, end)) {
            is_refused_ = true;
            return false;
        }
        for (std::size_t i = begin; i < end; i += LeafTable::batch_size) {
            const std::span batch(voxels_.masks.data() + i, std::min(LeafTable::batch_size, end - i));
            if (!leaves_.find_or_insert(batch, &row.numbers[i - begin], scratch.leaves))
                return false;
        }
        for (std::uint32_t level = leaf_level + 1; level <= cut; ++level)
            if (!climb(row, level, scratch))
                return false;
        return true;
    }

    [[nodiscard]] bool are_usable(std::size_t begin, std::size_t end) const {
        bool is_wrong = begin > 0 && voxels_.codes[begin - 1] >= voxels_.codes[begin];
        for (std::size_t i = begin + 1; i < end; ++i)
            is_wrong |= voxels_.codes[i - 1] >= voxels_.codes[i];
        for (std::size_t i = begin; i < end; ++i)
            is_wrong |= voxels_.masks[i] == 0;
        return !is_wrong && voxels_.codes[end - 1] >> 3 * (voxels_.level - leaf_level) == 0;
    }

    /// The row of `level` in place of the one below. False, and the row is spoilt, where the table is full.
    bool climb(Row& row, std::uint32_t level, Scratch& scratch) {
        std::array<Children, NodeTable::batch_size> batch;
        std::size_t count = 0;
        for (std::size_t i = 0; i < row.codes.size();) {
            std::size_t batched = 0;
            for (; batched < batch.size() && i < row.codes.size(); ++batched) {
                const std::uint64_t code = row.codes[i] >> 3;
                Children& children = batch[batched] = {};
                do
                    children[row.codes[i] & 7] = row.numbers[i];
                while (++i < row.codes.size() && row.codes[i] >> 3 == code);
                row.codes[count + batched] = code; // never beyond i: parents are no more than children
            }
            if (!table(level).find_or_insert({batch.data(), batched}, &row.numbers[count], scratch.nodes[level]))
                return false;
            count += batched;
        }
        row.codes.resize(count);
        row.numbers.resize(count);
        return true;
    }

    template <class Table>
    void make_room(Table& full, std::size_t count) {
        std::uint64_t bytes = leaves_.memory_bytes();
        for (const NodeTable& nodes : nodes_)
            bytes += nodes.memory_bytes();
        bytes += Table::memory_bytes(full.past() + count); // beside the old one, for a while
        require(bytes <= config_.memory_budget_bytes, "voxel DAG: ", voxels_.codes.size(), " bricks need more than ",
                bytes >> 20, " MiB; the budget is ", config_.memory_budget_bytes >> 20, " MiB");
        full.make_room(count, progress_);
    }

    Dag number_from_root(std::uint32_t root) {
        Dag dag{.level = voxels_.level, .leaves = {}, .levels = std::vector<DagLevel>(nodes_.size())};
        std::vector<std::uint32_t> names{root};
        for (std::size_t i = nodes_.size(); i-- > 0;) {
            const auto record_of = [&](std::size_t node) -> const Children& { return nodes_[i][names[node]]; };
            dag.levels[i] = written_level(names.size(), record_of, 0, progress_);
            const std::size_t below = i > 0 ? nodes_[i - 1].past() : leaves_.past();
            names = number_by_first_use(dag.levels[i].children, below, progress_);
            nodes_.pop_back();
        }
        dag.leaves.reserve(names.size());
        for (const std::uint32_t name : names)
            dag.leaves.push_back(leaves_[name]);
        return dag;
    }

    const LeafMasks& voxels_;
    const BuildConfig& config_;
    const Progress& progress_;
    LeafTable leaves_;
    std::deque<NodeTable> nodes_; ///< Of levels leaf_level + 1 and up.
    tbb::enumerable_thread_specific<Scratch> scratches_;
    std::atomic<bool> is_refused_ = false;
};
} // namespace

std::uint64_t estimated_build_bytes(std::size_t brick_count, std::uint32_t level) {
    std::uint64_t bytes = LeafTable::memory_bytes(expected_leaves(brick_count));
    for (std::uint32_t at = leaf_level + 1; at <= level; ++at)
        bytes += NodeTable::memory_bytes(expected_nodes(brick_count, at));
    return bytes;
}

Dag build_dag(const LeafMasks& voxels, const BuildConfig& config, const Progress& progress) {
    progress.poll();
    if (voxels.codes.empty() || voxels.codes.size() != voxels.masks.size() || voxels.level > most_level ||
        voxels.level < leaf_level) {
        require_usable(voxels);
        return {.level = voxels.level, .leaves = {}, .levels = {}};
    }
    const std::uint64_t bytes = estimated_build_bytes(voxels.codes.size(), voxels.level);
    require(bytes <= config.memory_budget_bytes, "voxel DAG: ", voxels.codes.size(), " bricks need about ", bytes >> 20,
            " MiB; the budget is ", config.memory_budget_bytes >> 20, " MiB");
    return Reduction(voxels, config, progress).run();
}
} // namespace tyndall::voxel_dag
