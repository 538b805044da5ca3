// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/join_parts.hpp"
#include "voxel_dag/canonical.hpp"
#include "voxel_dag/first_use.hpp"
#include "voxel_dag/subgroups.hpp"
#include "voxel_dag/unique_table.hpp"
#include <algorithm>
#include <numeric>
#include <tbb/enumerable_thread_specific.h>

namespace tyndall::voxel_dag {
namespace {
/// What the nodes of a level have become: all of the first part, then all of the next.
struct Merged {
    std::vector<std::uint32_t> numbers;
    std::vector<std::uint8_t> tags, stabilizers;

    explicit Merged(std::size_t count) : numbers(count), tags(count), stabilizers(count) {}
    /// What `place` is, turned by `tag` where it stands.
    [[nodiscard]] MergedNode turned(std::size_t place, std::uint8_t tag) const {
        const std::uint8_t stabilizer = stabilizers[place];
        return {.number = numbers[place],
                .tag = subgroups().coset[stabilizer][cube_group.product[tag][tags[place]]],
                .stabilizer = stabilizer};
    }
};

/// Where the nodes of a level come from, part by part.
struct Source {
    std::vector<std::size_t> first; ///< Place of each part's first node in the level, and one past the last.
    std::size_t reference_count;    ///< Of all of them.
};

void append(const DagLevel& part, DagLevel& level) {
    const std::uint32_t first = level.first_children.back();
    level.child_masks.insert(level.child_masks.end(), part.child_masks.begin(), part.child_masks.end());
    for (std::size_t node = 1; node <= part.node_count(); ++node)
        level.first_children.push_back(first + part.first_children[node]);
    level.children.insert(level.children.end(), part.children.begin(), part.children.end());
    level.tags.insert(level.tags.end(), part.tags.begin(), part.tags.end());
}

class DagJoining {
public:
    DagJoining(std::span<const PartFile> parts, const JoinConfig& config, const Progress& progress,
               const std::function<void(double)>& report)
        : config_(config), progress_(progress), report_(report) {
        for (const PartFile& part : parts)
            if (!part.is_empty())
                parts_.push_back(&part);
        for (const PartFile* part : parts_)
            for (std::uint32_t level = leaf_level; level <= config.part_level; ++level)
                node_count_ += part->node_count(level);
    }

    JoinResult run() {
        Dag& dag = result_.dag;
        dag.level = config_.level;
        dag.symmetry = config_.symmetry;
        if (parts_.empty())
            return std::move(result_);
        join_leaves();
        for (std::uint32_t level = leaf_level + 1; level <= config_.part_level; ++level)
            join_level(level);
        join_roots();
        return std::move(result_);
    }

private:
    [[nodiscard]] Source source_of(std::uint32_t level) const {
        Source source{.first = {0}, .reference_count = 0};
        for (const PartFile* part : parts_) {
            source.first.push_back(source.first.back() + part->node_count(level));
            source.reference_count += part->reference_count(level);
        }
        return source;
    }

    void join_leaves() {
        const Source source = source_of(leaf_level);
        const auto open = [&](std::size_t part) {
            return [leaves = parts_[part]->read_leaves(progress_), this](std::size_t leaf) {
                return config_.symmetry == Symmetry::None
                           ? Canonical<std::uint64_t>{.node = leaves[leaf], .tag = 0, .stabilizer = 0}
                           : canonical_leaf(leaves[leaf], config_.symmetry);
            };
        };
        result_.dag.leaves.reserve(number<std::uint64_t>(source, open));
        collect<std::uint64_t>(source, open, [&](const std::vector<std::uint64_t>& leaves) {
            result_.dag.leaves.insert(result_.dag.leaves.end(), leaves.begin(), leaves.end());
        });
        below_ = std::move(merged_);
        below_first_ = source.first;
    }

    void join_level(std::uint32_t level) {
        const Source source = source_of(level);
        merge(source, [&](std::size_t part) { return parts_[part]->read_level(level, progress_); });
    }

    /// The levels above the parts, which a surface has few nodes in.
    void join_roots() {
        std::vector<std::uint64_t> codes;
        std::vector<std::uint8_t> tags; // of the references to the nodes below
        for (const PartFile* part : parts_) {
            codes.push_back(part->code());
            tags.push_back(part->root_tag());
        }
        for (std::uint32_t level = config_.part_level + 1; level <= config_.level; ++level) {
            DagLevel nodes{.child_masks = {}, .first_children = {0}, .children = {}, .tags = {}};
            std::vector<std::uint64_t> parents;
            for (std::size_t i = 0; i < codes.size(); ++i) {
                if (parents.empty() || parents.back() != codes[i] >> 3) {
                    parents.push_back(codes[i] >> 3);
                    nodes.child_masks.push_back(0);
                    nodes.first_children.push_back(nodes.first_children.back());
                }
                nodes.child_masks.back() |= static_cast<std::uint8_t>(1u << (codes[i] & 7));
                ++nodes.first_children.back();
                nodes.children.push_back(static_cast<std::uint32_t>(i));
            }
            if (config_.symmetry != Symmetry::None)
                nodes.tags = tags;
            merge({.first = {0, parents.size()}, .reference_count = codes.size()}, [&](std::size_t) { return nodes; });
            codes = std::move(parents);
            tags.assign(codes.size(), 0);
        }
        result_.dag.root_tag = below_.turned(0, tags.front()).tag;
    }

    /// A level of nodes that read(part) brings, on top of what is there.
    template <class Read>
    void merge(const Source& source, const Read& read) {
        const auto open = [&](std::size_t part) {
            return [nodes = read(part), first = below_first_[part], this](std::size_t node) {
                return canonical_node(nodes, node, config_.symmetry, [&](std::size_t reference) {
                    return below_.turned(first + nodes.children[reference], nodes.tag(reference));
                });
            };
        };
        const std::size_t count = number<TurnedChildren>(source, open);
        DagLevel level{.child_masks = {}, .first_children = {0}, .children = {}, .tags = {}};
        level.child_masks.reserve(count);
        level.first_children.reserve(count + 1);
        // Distinct nodes have about as many children as all: hardly ever is more needed, and memory that is not stays free.
        const auto expected =
            static_cast<std::size_t>(1.25 * static_cast<double>(source.reference_count) * static_cast<double>(count) /
                                     static_cast<double>(source.first.back()));
        level.children.reserve(expected);
        level.tags.reserve(config_.symmetry == Symmetry::None ? 0 : expected);
        collect<TurnedChildren>(source, open, [&](const std::vector<TurnedChildren>& nodes) {
            const auto record_of = [&](std::size_t node) -> const TurnedChildren& { return nodes[node]; };
            DagLevel part = written_level(nodes.size(), record_of, 1, progress_);
            if (config_.symmetry == Symmetry::None)
                part.tags.clear();
            append(part, level);
        });
        result_.dag.levels.push_back(std::move(level));
        below_ = std::move(merged_);
        below_first_ = source.first;
    }

    /// Numbers the nodes of a level in merged_, in the order of first use. open(part)(node) is canonical. Returns how many
    /// numbers there are.
    template <class Node, class Open>
    std::size_t number(const Source& source, const Open& open) {
        const std::size_t count = source.first.back();
        require(count < ~std::uint32_t{0}, "voxel DAG: the parts have ", count,
                " nodes of one level; fewer than 2^32 - 1 ", "are possible: choose a smaller resolution");
        merged_ = Merged(count);
        const std::size_t pass_count = passes_for<Node>(count);
        result_.statistics.most_passes =
            std::max(result_.statistics.most_passes, static_cast<std::uint32_t>(pass_count));
        std::size_t name_count = 0;
        for (std::size_t pass = 0; pass < pass_count; ++pass) {
            UniqueTable<Node> table(expected_names<Node>(count / pass_count));
            Reserves<Node> reserves;
            for (std::size_t part = 0; part + 1 < source.first.size(); ++part)
                look_up<Node>(open(part), source.first[part], source.first[part + 1] - source.first[part],
                              {.pass = pass, .pass_count = pass_count, .first_name = name_count}, table, reserves);
            name_count += table.past();
            require(name_count < ~std::uint32_t{0},
                    "voxel DAG: 2^32 distinct nodes of one level: choose a smaller resolution");
        }
        const std::vector<std::uint32_t> names = number_by_first_use(merged_.numbers, name_count, progress_);
        done_count_ += count;
        report_(static_cast<double>(done_count_) / static_cast<double>(node_count_));
        return names.size();
    }

    template <class Node>
    using Reserves = tbb::enumerable_thread_specific<typename UniqueTable<Node>::Reserve>;
    /// Nodes differ from part to part, leaves hardly.
    template <class Node>
    [[nodiscard]] static std::size_t expected_names(std::size_t count) {
        return std::is_same_v<Node, TurnedChildren> ? count : count / 8;
    }

    struct Pass {
        std::size_t pass, pass_count, first_name;
    };
    /// Names of those nodes of one part that this pass is for.
    template <class Node, class CanonicalOf>
    void look_up(const CanonicalOf& canonical_of, std::size_t first, std::size_t count, const Pass& pass,
                 UniqueTable<Node>& table, Reserves<Node>& reserves) {
        using Table = UniqueTable<Node>;
        for (std::atomic<bool> is_full = true; is_full.exchange(false);) {
            parallel_blocks(count, Table::batch_size * 128, progress_, [&](std::size_t begin, std::size_t end) {
                typename Table::Reserve& reserve = reserves.local();
                std::array<Node, Table::batch_size> batch;
                std::array<std::size_t, Table::batch_size> places;
                std::size_t batched = 0;
                const auto flush = [&] {
                    std::array<std::uint32_t, Table::batch_size> numbers;
                    if (!table.find_or_insert({batch.data(), batched}, numbers.data(), reserve))
                        return false;
                    for (std::size_t i = 0; i < batched; ++i)
                        merged_.numbers[places[i]] = static_cast<std::uint32_t>(pass.first_name + numbers[i]);
                    batched = 0;
                    return true;
                };
                for (std::size_t node = begin; node < end; ++node) {
                    const Canonical<Node> canonical = canonical_of(node);
                    merged_.tags[first + node] = canonical.tag;
                    merged_.stabilizers[first + node] = canonical.stabilizer;
                    if ((hash_of(canonical.node) >> 32) % pass.pass_count != pass.pass) // what slots go by is below
                        continue;
                    batch[batched] = canonical.node;
                    places[batched++] = first + node;
                    if (batched == batch.size() && !flush())
                        return is_full.store(true);
                }
                if (!flush())
                    is_full.store(true);
            });
            if (is_full)
                table.make_room(table.past(), progress_);
        }
    }

    /// Hands out the canonical nodes in the order of their numbers, some at a time.
    template <class Node, class Open, class Receive>
    void collect(const Source& source, const Open& open, const Receive& receive) {
        std::uint32_t next = 0;
        for (std::size_t part = 0; part + 1 < source.first.size(); ++part) {
            std::vector<std::size_t> firsts; // nodes that appear for the first time
            for (std::size_t place = source.first[part]; place < source.first[part + 1]; ++place)
                if (merged_.numbers[place] == next) {
                    firsts.push_back(place - source.first[part]);
                    ++next;
                }
            const auto canonical_of = open(part);
            std::vector<Node> nodes(firsts.size());
            parallel_for(
                nodes.size(), progress_, [&](std::size_t i) { nodes[i] = canonical_of(firsts[i]).node; }, 1 << 12);
            receive(nodes);
        }
    }

    /// How often the parts have to be read, so that the table for each time's share fits what the budget has left.
    template <class Node>
    [[nodiscard]] std::size_t passes_for(std::size_t count) const {
        std::uint64_t used = (below_.numbers.size() + count) * 6 + 8 * result_.dag.leaves.size();
        for (const DagLevel& nodes : result_.dag.levels)
            used += 5 * (nodes.node_count() + nodes.children.size());
        require(used < config_.memory_budget_bytes, "voxel DAG: the graph of ", parts_.size(),
                " parts needs more than ", used >> 20, " MiB, and the budget is ", config_.memory_budget_bytes >> 20,
                " MiB: allow more");
        std::size_t passes = 1;
        while (passes < most_passes && UniqueTable<Node>::memory_bytes(expected_names<Node>(count / passes)) >
                                           (config_.memory_budget_bytes - used) / 2)
            ++passes;
        return passes;
    }

    static constexpr std::size_t most_passes = 64;
    const JoinConfig& config_;
    const Progress& progress_;
    const std::function<void(double)>& report_;
    std::vector<const PartFile*> parts_; ///< Those that have voxels.
    std::size_t node_count_ = 0, done_count_ = 0;
    Merged below_{0}, merged_{0};
    std::vector<std::size_t> below_first_; ///< In below_: each part's first node.
    JoinResult result_;
};
} // namespace

JoinResult join_parts(std::span<const PartFile> parts, const JoinConfig& config, const Progress& progress,
                      const std::function<void(double)>& report) {
    progress.poll();
    return DagJoining(parts, config, progress, report).run();
}
} // namespace tyndall::voxel_dag
