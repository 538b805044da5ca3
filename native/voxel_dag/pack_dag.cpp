// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/pack_dag.hpp"
#include "core/parallel.hpp"
#include "voxel_dag/cube_group.hpp"
#include "voxel_dag/upright.hpp"
#include "voxel_dag/use_ranks.hpp"
#include <algorithm>
#include <atomic>
#include <hwy/cache_control.h>
#include <numeric>
#include <tbb/enumerable_thread_specific.h>

namespace tyndall::voxel_dag {
namespace {
constexpr std::size_t fewest_ready = 256; ///< Records that threads can share among them.

/// For each octant as it lies in the world, the reference to the child there; that of a node which `turn` has turned.
template <class Visit>
void for_each_child(const DagLevel& nodes, std::size_t node, std::uint32_t turn, const Visit& visit) {
    for (std::uint32_t there = 0; there < 8; ++there)
        if (const std::uint32_t octant = cube_group.octant[cube_group.inverse[turn]][there];
            (nodes.child_masks[node] >> octant & 1) != 0)
            visit(there, nodes.reference(node, octant));
}

/// Counts that add up.
template <std::size_t Size>
struct UseSums {
    std::array<std::uint32_t, Size> of{};
    UseSums& operator+=(const UseSums& other) {
        for (std::size_t i = 0; i < Size; ++i)
            of[i] += other.of[i];
        return *this;
    }
};

class Packing {
public:
    Packing(const Dag& dag, const PackConfig& config, const Progress& progress)
        : dag_(dag), config_(config), progress_(progress) {}

    PackedDag run() {
        packed_.level = dag_.level;
        packed_.tag_bits = static_cast<std::uint32_t>(std::bit_width(symmetry_order(dag_.symmetry) - 1));
        packed_.leaf_bits = static_cast<std::uint32_t>(std::bit_width(dag_.leaves.size()));
        packed_.leaves = dag_.leaves;
        for (std::size_t i = 0; i + 1 < dag_.levels.size(); ++i)
            shared_.push_back(ranked(dag_.levels[i + 1].children, dag_.levels[i].node_count()));
        upright_ = upright_turns(
            dag_, config_.has_inner_tags, [&](std::size_t i, std::uint32_t node) { return is_shared(i, node); },
            progress_);
        name_pairs();
        for (std::size_t i = 0; i < dag_.levels.size(); ++i) {
            PackedLevel& format = packed_.levels.emplace_back();
            rank_masks(i, format);
            if (i == 0) {
                format.classes = best_classes(pair_ranks_.uses, 0);
                format.field_bits = format.classes.widths;
            } else {
                rank_tags(i, format);
            }
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
    using TagRanks = std::array<std::uint8_t, cube_element_count>;

    [[nodiscard]] bool is_shared(std::size_t i, std::uint32_t node) const {
        return i < shared_.size() && shared_[i].rank[node] != no_rank;
    }

    /// visit(leaf, the smallest tag that turns it into the brick there) of all bricks that a record of 8^3 names.
    template <class Visit>
    void for_each_brick(std::size_t node, const Visit& visit) const {
        const DagLevel& nodes = dag_.levels.front();
        for (std::size_t at = nodes.first_children[node]; at < nodes.first_children[node + 1]; ++at)
            visit(nodes.children[at], brick_tag(node, at));
    }
    [[nodiscard]] std::uint32_t brick_tag(std::size_t node, std::size_t reference) const {
        const DagLevel& nodes = dag_.levels.front();
        return upright_.brick_turn(nodes.children[reference],
                                   cube_group.product[upright_.turns[0][node]][nodes.tag(reference)]);
    }
    /// The number of a brick among those that records name, by leaf and tag.
    [[nodiscard]] std::uint32_t pair_of(std::uint32_t leaf, std::uint32_t tag) const {
        const std::uint64_t before = leaf_tags_[leaf] & ((std::uint64_t{1} << tag) - 1);
        return first_pairs_[leaf] + static_cast<std::uint32_t>(std::popcount(before));
    }

    /// A pair for each different brick that records of 8^3 name, in the order of how often they do.
    void name_pairs() {
        leaf_tags_.resize(dag_.leaves.size(), 0);
        if (dag_.levels.empty())
            leaf_tags_[0] = std::uint64_t{1} << dag_.root_tag;
        else
            parallel_for(
                dag_.levels.front().node_count(), progress_,
                [&](std::size_t node) {
                    for_each_brick(node, [&](std::uint32_t leaf, std::uint32_t tag) {
                        const std::atomic_ref tags(leaf_tags_[leaf]);
                        if ((tags.load(std::memory_order_relaxed) >> tag & 1) == 0)
                            tags.fetch_or(std::uint64_t{1} << tag, std::memory_order_relaxed);
                    });
                },
                1 << 12);
        std::uint32_t pair_count = 0;
        for (const std::uint64_t tags : leaf_tags_) {
            first_pairs_.push_back(pair_count);
            pair_count += static_cast<std::uint32_t>(std::popcount(tags));
        }
        std::vector<std::uint32_t> uses(pair_count, dag_.levels.empty() ? 1 : 0);
        if (!dag_.levels.empty())
            parallel_for(
                dag_.levels.front().node_count(), progress_,
                [&](std::size_t node) {
                    for_each_brick(node, [&](std::uint32_t leaf, std::uint32_t tag) {
                        std::atomic_ref(uses[pair_of(leaf, tag)]).fetch_add(1, std::memory_order_relaxed);
                    });
                },
                1 << 12);
        pair_ranks_ = ranked_by(uses, 1);
        std::vector<std::uint64_t> pairs; // leaf and tag by number
        for (std::uint32_t leaf = 0; leaf < leaf_tags_.size(); ++leaf)
            for (std::uint64_t tags = leaf_tags_[leaf]; tags != 0; tags &= tags - 1)
                pairs.push_back(leaf | static_cast<std::uint64_t>(std::countr_zero(tags)) << packed_.leaf_bits);
        BitWriter fields;
        for (const std::uint32_t pair : pair_ranks_.names)
            fields.append(pairs[pair], packed_.leaf_bits + packed_.tag_bits);
        packed_.pairs = std::move(fields).padded_words();
    }

    /// What turns the record that a reference of levels[i] names, or that lies inside, into what is there; of equal ones
    /// the one of the lowest rank.
    [[nodiscard]] std::uint32_t tag_of(std::size_t i, std::size_t node, std::size_t reference,
                                       const TagRanks& ranks) const {
        const DagLevel& nodes = dag_.levels[i];
        const std::uint32_t child = nodes.children[reference];
        const std::uint32_t turned = cube_group.product[upright_.turns[i][node]][nodes.tag(reference)];
        std::uint32_t best = cube_group.product[turned][cube_group.inverse[upright_.turns[i - 1][child]]];
        if (i == 1 && is_shared(0, child))
            for (std::uint64_t left = upright_.keeping(child); left != 0; left &= left - 1) {
                const std::uint32_t tag =
                    cube_group.product[turned][cube_group.product[cube_group.inverse[upright_.turns[0][child]]]
                                                                 [static_cast<std::size_t>(std::countr_zero(left))]];
                best = ranks[tag] < ranks[best] ? tag : best;
            }
        return best;
    }
    /// Whether records of levels[i] give what lies inside them a tag.
    [[nodiscard]] bool has_inner_tags(std::size_t i) const { return upright_.has_inner_tags && i == 2; }

    /// visit(sums, whether the child is shared, its number, its tag) of all that references of levels[i] name, side by side.
    template <class UseSums, class Visit>
    [[nodiscard]] UseSums tag_sums(std::size_t i, const TagRanks& ranks, const Visit& visit) const {
        const DagLevel& nodes = dag_.levels[i];
        return parallel_sum(nodes.node_count(), 1 << 14, UseSums{}, progress_, [&](std::size_t begin, std::size_t end) {
            UseSums sums;
            for (std::size_t node = begin; node < end; ++node)
                for (std::size_t at = nodes.first_children[node]; at < nodes.first_children[node + 1]; ++at)
                    if (const bool is_named = is_shared(i - 1, nodes.children[at]); is_named || has_inner_tags(i))
                        visit(sums, is_named, nodes.children[at], tag_of(i, node, at, ranks));
            return sums;
        });
    }
    /// The tags of a level's references by falling use, the one that changes nothing first; and classes.
    void rank_tags(std::size_t i, PackedLevel& format) {
        TagRanks& ranks = tag_ranks_.emplace_back();
        std::iota(ranks.begin(), ranks.end(), std::uint8_t{0});
        const auto uses = tag_sums<UseSums<cube_element_count>>(
            i, ranks, [](auto& sums, bool, std::uint32_t, std::uint32_t tag) { ++sums.of[tag]; });
        std::array<std::uint8_t, cube_element_count> order = ranks;
        std::stable_sort(order.begin() + 1, order.end(), [&](auto a, auto b) { return uses.of[a] > uses.of[b]; });
        for (std::uint8_t rank = 0; rank < order.size(); ++rank) {
            ranks[order[rank]] = rank;
            format.tags[rank] = rank < symmetry_order(dag_.symmetry) ? order[rank] : std::uint8_t{0};
        }
        constexpr std::size_t tag_widths = std::tuple_size_v<TaggedUses::value_type>;
        const auto flat = tag_sums<UseSums<std::tuple_size_v<TaggedUses> * tag_widths>>(
            i, ranks, [&](auto& sums, bool is_named, std::uint32_t child, std::uint32_t tag) {
                const auto tag_bits = static_cast<std::size_t>(std::bit_width(std::uint32_t{ranks[tag]}));
                if (is_named)
                    ++sums.of[tag_widths * static_cast<std::size_t>(std::bit_width(shared_[i - 1].rank[child])) +
                              tag_bits];
            });
        TaggedUses tagged{};
        for (std::size_t at = 0; at < flat.of.size(); ++at)
            tagged[at / tag_widths][at % tag_widths] = flat.of[at];
        tagged_.push_back(best_tagged_classes(tagged));
        format.classes = {.widths = tagged_.back().rank_bits, .begins = {}};
        format.field_bits[0] = has_inner_tags(i) ? packed_.tag_bits : 0;
        for (std::size_t at = 1; at < 4; ++at)
            format.field_bits[at] = tagged_.back().rank_bits[at] + tagged_.back().tag_bits[at];
    }

    /// The child masks of a level's records, by falling number of records.
    void rank_masks(std::size_t i, PackedLevel& format) {
        const DagLevel& nodes = dag_.levels[i];
        const auto uses = parallel_sum(
            nodes.node_count(), 1 << 14, UseSums<256>{}, progress_, [&](std::size_t begin, std::size_t end) {
                UseSums<256> counted;
                for (std::size_t node = begin; node < end; ++node) {
                    std::uint32_t mask = 0;
                    for_each_child(nodes, node, upright_.turns[i][node],
                                   [&](std::uint32_t there, std::size_t) { mask |= 1u << there; });
                    ++counted.of[mask];
                }
                return counted;
            });
        mask_ranks_.push_back(ranked_by({uses.of.begin(), uses.of.end()}, 1));
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
            blocks[at] = {};
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
        const std::uint32_t turn = upright_.turns[i][node];
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
                const std::uint32_t rank = pair_ranks_.rank[pair_of(child, brick_tag(node, reference))];
                at_class = formats.class_of(rank, 0);
                fields[count] = rank - formats.begins[at_class];
            } else if (is_shared(i - 1, child)) {
                const std::uint32_t rank = shared_[i - 1].rank[child];
                const std::uint64_t tag_rank = tag_ranks_[i - 1][tag_of(i, node, reference, tag_ranks_[i - 1])];
                at_class = tagged_[i - 1].class_of(rank, static_cast<std::uint32_t>(tag_rank));
                fields[count] = rank | tag_rank << formats.widths[at_class];
            } else {
                if (has_inner_tags(i))
                    fields[count] = tag_ranks_[i - 1][tag_of(i, node, reference, tag_ranks_[i - 1])];
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
    const PackConfig& config_;
    const Progress& progress_;
    PackedDag packed_;
    std::vector<Ranks> shared_; ///< By level, the root's apart: nodes of two or more references.
    Upright upright_;
    std::vector<std::uint64_t> leaf_tags_;   ///< By leaf, bit t: records name its brick of tag t.
    std::vector<std::uint32_t> first_pairs_; ///< By leaf: the number of its first pair.
    std::vector<TagRanks> tag_ranks_;        ///< By level from 16^3 on, and tag.
    std::vector<TaggedClasses> tagged_;      ///< As many.
    Ranks pair_ranks_;
    std::vector<Ranks> mask_ranks_; ///< By level.
    tbb::enumerable_thread_specific<Scratch> scratches_;
    std::size_t ready_level_ = ~std::size_t{0}; ///< Of which the records that lie inside others are written already.
    std::vector<BitWriter> ready_;              ///< Those, by node.
};
} // namespace

std::uint64_t estimated_pack_bytes(const Dag& dag) {
    // Beside the DAG 46 to 59 per node were measured at 8K^3, and some more of small ones: what threads keep.
    constexpr std::uint64_t bytes_per_node = 72, bytes_per_node_of_small = 16, most_of_small = 4 << 20;
    std::uint64_t dag_bytes = sizeof(std::uint64_t) * dag.leaves.size();
    for (const DagLevel& nodes : dag.levels)
        dag_bytes += nodes.child_masks.size() + nodes.tags.size() +
                     sizeof(std::uint32_t) * (nodes.first_children.size() + nodes.children.size());
    return dag_bytes + bytes_per_node * dag.node_count() +
           std::min(bytes_per_node_of_small * dag.node_count(), most_of_small);
}

PackedDag pack_dag(const Dag& dag, const Progress& progress, const PackConfig& config) {
    progress.poll();
    if (dag.is_empty())
        return {.level = dag.level, .leaves = {}, .pairs = {}, .records = {}, .levels = {}};
    PackedDag packed = Packing(dag, config, progress).run();
    packed.voxel_count = dag.voxel_count();
    packed.node_count = dag.node_count();
    return packed;
}
} // namespace tyndall::voxel_dag
