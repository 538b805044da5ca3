// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/pack_dag.hpp"
#include "core/parallel.hpp"
#include "voxel_dag/cube_group.hpp"
#include "voxel_dag/first_use.hpp"
#include "voxel_dag/unique_table.hpp"
#include <algorithm>
#include <hwy/cache_control.h>
#include <numeric>
#include <tbb/enumerable_thread_specific.h>

namespace tyndall::voxel_dag {
namespace {
constexpr std::uint32_t no_rank = ~std::uint32_t{0};
constexpr std::size_t fewest_ready = 256; ///< Records that threads can share among them.

/// Names in the order of how often they are named, and the rank of each; those below `fewest` uses have none.
struct Ranks {
    std::vector<std::uint32_t> uses;  ///< By rank, falling.
    std::vector<std::uint32_t> names; ///< By rank.
    std::vector<std::uint32_t> rank;  ///< By name.
};
Ranks ranked(const std::vector<std::uint32_t>& references, std::size_t name_count, std::uint32_t fewest) {
    std::vector<std::uint32_t> uses(name_count, 0);
    for (const std::uint32_t name : references)
        ++uses[name];
    Ranks ranks;
    for (std::uint32_t name = 0; name < name_count; ++name)
        if (uses[name] >= fewest)
            ranks.names.push_back(name);
    std::ranges::stable_sort(ranks.names, std::greater(), [&](std::uint32_t name) { return uses[name]; });
    ranks.rank.assign(name_count, no_rank);
    for (std::uint32_t i = 0; i < ranks.names.size(); ++i) {
        ranks.rank[ranks.names[i]] = i;
        ranks.uses.push_back(uses[ranks.names[i]]);
    }
    return ranks;
}

/// For each octant as it lies in the world, the reference to the child there; that of a node which `turn` has turned.
template <class Visit>
void for_each_child(const DagLevel& nodes, std::size_t node, std::uint32_t turn, const Visit& visit) {
    for (std::uint32_t there = 0; there < 8; ++there)
        if (const std::uint32_t octant = cube_group.octant[cube_group.inverse[turn]][there];
            (nodes.child_masks[node] >> octant & 1) != 0)
            visit(there, nodes.reference(node, octant));
}

class Packing {
public:
    Packing(const Dag& dag, const Progress& progress) : dag_(dag), progress_(progress), turns_(dag.levels.size()) {}

    PackedDag run() {
        packed_.level = dag_.level;
        packed_.tag_bits = static_cast<std::uint32_t>(std::bit_width(symmetry_order(dag_.symmetry) - 1));
        packed_.leaf_bits = static_cast<std::uint32_t>(std::bit_width(dag_.leaves.size()));
        packed_.leaves = dag_.leaves;
        for (std::size_t i = 0; i + 1 < dag_.levels.size(); ++i)
            shared_.push_back(ranked(dag_.levels[i + 1].children, dag_.levels[i].node_count(), 2));
        turn_what_lies_inside();
        name_pairs();
        for (std::size_t i = 0; i < dag_.levels.size(); ++i) {
            const std::uint32_t first_class = i == 0 ? 0 : 1;
            PackedLevel format{.mask_classes = {},
                               .child_masks = {},
                               .classes = best_classes(i == 0 ? pair_ranks_.uses : shared_[i - 1].uses, first_class),
                               .field_bits = {},
                               .directory = {}};
            for (std::uint32_t at = first_class; at < 4; ++at)
                format.field_bits[at] = format.classes.widths[at] + (i == 0 ? 0 : packed_.tag_bits);
            rank_masks(i, format);
            packed_.levels.push_back(std::move(format));
        }
        BitWriter records;
        for (std::size_t i = 0; i < shared_.size(); ++i) {
            write_shared(i, records);
            if (dag_.levels[i + 1].node_count() < fewest_ready && ready_.empty())
                write_ready(i);
        }
        packed_.root_bit = records.size();
        if (!dag_.levels.empty())
            write(dag_.levels.size() - 1, 0, records, scratches_.local());
        packed_.records = std::move(records).padded_words();
        return std::move(packed_);
    }

private:
    using Scratch = std::array<BitWriter, most_level>;

    [[nodiscard]] bool is_shared(std::size_t i, std::uint32_t node) const {
        return i < shared_.size() && shared_[i].rank[node] != no_rank;
    }

    /// From the root down: what lies inside another record is turned with it.
    void turn_what_lies_inside() {
        for (std::size_t i = dag_.levels.size(); i-- > 0;) {
            turns_[i].resize(dag_.levels[i].node_count(), 0);
            if (i + 1 == dag_.levels.size()) {
                turns_[i][0] = dag_.root_tag;
                continue;
            }
            const DagLevel& above = dag_.levels[i + 1];
            parallel_for(above.node_count(), progress_, [&](std::size_t node) {
                for (std::size_t at = above.first_children[node]; at < above.first_children[node + 1]; ++at)
                    if (!is_shared(i, above.children[at]))
                        turns_[i][above.children[at]] = cube_group.product[turns_[i + 1][node]][above.tag(at)];
            });
        }
    }

    /// A pair for each different brick that records of 8^3 name, in the order of how often they do.
    void name_pairs() {
        std::vector<std::uint32_t> tags;   // by reference
        std::vector<std::uint32_t> leaves; // by reference
        if (dag_.levels.empty()) {
            leaves.assign(dag_.leaves.size(), 0);
            tags.assign(dag_.leaves.size(), dag_.root_tag);
        } else {
            const DagLevel& nodes = dag_.levels.front();
            leaves = nodes.children;
            tags.resize(leaves.size());
            parallel_for(nodes.node_count(), progress_, [&](std::size_t node) {
                for (std::size_t at = nodes.first_children[node]; at < nodes.first_children[node + 1]; ++at)
                    tags[at] = cube_group.product[turns_[0][node]][nodes.tag(at)];
            });
        }
        pairs_ = leaves;
        number_bricks(tags);
        std::vector<std::size_t> first_reference; // by pair
        for (std::size_t at = 0; at < pairs_.size(); ++at)
            if (pairs_[at] == first_reference.size())
                first_reference.push_back(at);
        pair_ranks_ = ranked(pairs_, first_reference.size(), 1);
        BitWriter fields;
        for (const std::uint32_t pair : pair_ranks_.names) {
            fields.append(leaves[first_reference[pair]], packed_.leaf_bits);
            fields.append(tags[first_reference[pair]], packed_.tag_bits);
        }
        packed_.pairs = std::move(fields).padded_words();
    }

    /// pairs_, leaves' numbers before, become numbers of bricks as the tags turn them, in the order of first use.
    void number_bricks(const std::vector<std::uint32_t>& tags) {
        using Table = UniqueTable<std::uint64_t>;
        Table table(2 * dag_.leaves.size());
        tbb::enumerable_thread_specific<Table::Reserve> reserves;
        std::vector<std::uint32_t> numbers(pairs_.size());
        for (std::atomic<bool> is_full = true; is_full.exchange(false);) {
            parallel_blocks(pairs_.size(), Table::batch_size * 128, progress_, [&](std::size_t begin, std::size_t end) {
                Table::Reserve& reserve = reserves.local();
                for (std::size_t first = begin; first < end; first += Table::batch_size) {
                    std::array<std::uint64_t, Table::batch_size> batch;
                    const std::size_t batched = std::min(Table::batch_size, end - first);
                    for (std::size_t i = 0; i < batched; ++i)
                        batch[i] = turned_leaf(tags[first + i], dag_.leaves[pairs_[first + i]]);
                    if (!table.find_or_insert({batch.data(), batched}, &numbers[first], reserve))
                        return is_full.store(true);
                }
            });
            if (is_full)
                table.make_room(table.past(), progress_);
        }
        static_cast<void>(number_by_first_use(numbers, table.past(), progress_));
        pairs_ = std::move(numbers);
    }

    /// The child masks of a level's records, by falling number of records.
    void rank_masks(std::size_t i, PackedLevel& format) {
        const DagLevel& nodes = dag_.levels[i];
        std::vector<std::uint32_t> masks(nodes.node_count());
        parallel_for(
            masks.size(), progress_,
            [&](std::size_t node) {
                for_each_child(nodes, node, turns_[i][node],
                               [&](std::uint32_t there, std::size_t) { masks[node] |= 1u << there; });
            },
            1 << 12);
        mask_ranks_.push_back(ranked(masks, 256, 1));
        format.mask_classes = best_classes(mask_ranks_[i].uses, 0);
        std::ranges::transform(mask_ranks_[i].names, format.child_masks.begin(),
                               [](std::uint32_t mask) { return static_cast<std::uint8_t>(mask); });
    }

    void write_shared(std::size_t i, BitWriter& records) {
        constexpr std::size_t block = 512;
        const std::vector<std::uint32_t>& nodes = shared_[i].names;
        const std::uint32_t step = directory_step(static_cast<std::uint32_t>(i) + leaf_level + 1);
        static_assert(block % directory_step(leaf_level + 1) == 0);
        std::vector<BitWriter> blocks((nodes.size() + block - 1) / block);
        std::vector<std::uint64_t> begins(nodes.size()); // in their blocks
        parallel_blocks(nodes.size(), block, progress_, [&](std::size_t begin, std::size_t end) {
            BitWriter& out = blocks[begin / block];
            for (std::size_t rank = begin; rank < end; ++rank) {
                prefetch(dag_.levels[i], nodes, rank);
                begins[rank] = out.size();
                write(i, nodes[rank], out, scratches_.local());
            }
        });
        for (std::size_t at = 0; at < blocks.size(); ++at) {
            for (std::size_t rank = at * block; rank < std::min(nodes.size(), (at + 1) * block); rank += step) {
                const std::uint64_t bit = records.size() + begins[rank];
                require(bit >> 32 == 0, "voxel DAG: records that are used more than once take more than 512 MiB");
                packed_.levels[i].directory.push_back(static_cast<std::uint32_t>(bit));
            }
            records.append(blocks[at]);
        }
    }

    /// Nodes by rank lie anywhere: those that come are asked for, and where their children are before that.
    void prefetch(const DagLevel& nodes, const std::vector<std::uint32_t>& names, std::size_t rank) const {
        constexpr std::size_t ahead = 8;
        if (rank + 2 * ahead >= names.size())
            return;
        const std::uint32_t node = names[rank + 2 * ahead];
        hwy::Prefetch(&nodes.child_masks[node]);
        hwy::Prefetch(&nodes.first_children[node]);
        const std::uint32_t reference = nodes.first_children[names[rank + ahead]];
        hwy::Prefetch(&nodes.children[reference]);
        if (!nodes.tags.empty())
            hwy::Prefetch(&nodes.tags[reference]);
        if (&nodes == &dag_.levels.front())
            hwy::Prefetch(&pairs_[reference]);
    }

    /// What lies inside others from here on up is the root's one record, nearly all of a surface: its parts are written
    /// side by side.
    void write_ready(std::size_t i) {
        ready_.resize(dag_.levels[i].node_count());
        parallel_for(
            ready_.size(), progress_,
            [&](std::size_t node) {
                if (const auto number = static_cast<std::uint32_t>(node); !is_shared(i, number))
                    write(i, number, ready_[node], scratches_.local());
            },
            16);
        ready_level_ = i;
    }

    void write(std::size_t i, std::uint32_t node, BitWriter& out, Scratch& scratch) const {
        const DagLevel& nodes = dag_.levels[i];
        const std::uint32_t turn = turns_[i][node];
        const RankClasses& formats = packed_.levels[i].classes;
        std::uint32_t mask = 0, classes = 0, count = 0;
        BitWriter& inside = scratch[i];
        inside.clear();
        std::array<std::uint64_t, 8> fields{};
        std::array<std::uint32_t, 8> widths{}, lengths{};
        std::uint32_t inside_count = 0;
        for_each_child(nodes, node, turn, [&](std::uint32_t there, std::size_t reference) {
            mask |= 1u << there;
            const std::uint32_t child = nodes.children[reference];
            std::uint32_t at_class = 0;
            if (i == 0) {
                const std::uint32_t rank = pair_ranks_.rank[pairs_[reference]];
                at_class = formats.class_of(rank, 0);
                fields[count] = rank - formats.begins[at_class];
            } else if (is_shared(i - 1, child)) {
                const std::uint32_t rank = shared_[i - 1].rank[child];
                at_class = formats.class_of(rank, 1);
                const std::uint64_t tag = cube_group.product[turn][nodes.tag(reference)];
                fields[count] = (rank - formats.begins[at_class]) | tag << formats.widths[at_class];
            } else {
                const std::uint64_t begin = inside.size();
                if (i - 1 == ready_level_)
                    inside.append(ready_[child]);
                else
                    write(i - 1, child, inside, scratch);
                lengths[inside_count++] = static_cast<std::uint32_t>(inside.size() - begin);
            }
            widths[count] = packed_.levels[i].field_bits[at_class];
            classes |= at_class << 2 * count++;
        });
        const RankClasses& mask_formats = packed_.levels[i].mask_classes;
        const std::uint32_t mask_rank = mask_ranks_[i].rank[mask], mask_class = mask_formats.class_of(mask_rank, 0);
        const std::uint32_t mask_bits = 2 + mask_formats.widths[mask_class];
        out.append(mask_class | (mask_rank - mask_formats.begins[mask_class]) << 2 | classes << mask_bits,
                   mask_bits + 2 * count);
        for (std::uint32_t at = 0; at < count; ++at)
            out.append(fields[at], widths[at]);
        if (i > 1 && inside_count > 1) {
            const auto longest = *std::max_element(lengths.begin(), lengths.begin() + inside_count - 1);
            const auto width = static_cast<std::uint32_t>(std::bit_width(longest));
            out.append(width, 5);
            for (std::uint32_t at = 0; at + 1 < inside_count; ++at)
                out.append(lengths[at], width);
        }
        out.append(inside);
    }

    const Dag& dag_;
    const Progress& progress_;
    PackedDag packed_;
    std::vector<Ranks> shared_;                    ///< By level, the root's apart: nodes of two or more references.
    std::vector<std::vector<std::uint8_t>> turns_; ///< By level and node, as its record is written.
    std::vector<std::uint32_t> pairs_;             ///< By reference from 8^3 to leaves.
    Ranks pair_ranks_;
    std::vector<Ranks> mask_ranks_; ///< By level.
    tbb::enumerable_thread_specific<Scratch> scratches_;
    std::size_t ready_level_ = ~std::size_t{0}; ///< Of which the records that lie inside others are written already.
    std::vector<BitWriter> ready_;              ///< Those, by node.
};
} // namespace

std::uint64_t estimated_pack_bytes(const Dag& dag) {
    constexpr std::uint64_t bytes_per_node = 92; // of which the DAG's arrays are 26
    return bytes_per_node * dag.node_count();
}

PackedDag pack_dag(const Dag& dag, const Progress& progress) {
    progress.poll();
    if (dag.is_empty())
        return {.level = dag.level, .leaves = {}, .pairs = {}, .records = {}, .levels = {}};
    PackedDag packed = Packing(dag, progress).run();
    packed.voxel_count = dag.voxel_count();
    packed.node_count = dag.node_count();
    return packed;
}
} // namespace tyndall::voxel_dag
