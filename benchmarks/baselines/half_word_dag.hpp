// SPDX-License-Identifier: GPL-3.0-or-later
// A DAG in half-words: ESVDAG, and SSVDAG where it has reflections.
// Based on: Jaspe, dissertation 2018, 5.4.3 and figure 5.6: leaves of 4 x 4 x 4 are 64 bits; a level's nodes by falling
//           number of references; 16 bits with 2 per octant: no child, a reference of 16 bits (3 of tag, 13 of offset), or
//           one of 32 (3 and 29), whose code has the offset's 30th bit.
// Differs:  the root has a tag, too. The index has an offset per level, of 32 bits.
// Bound:    4 to 34 bytes per node, 8 per leaf.
#pragma once
#include "baselines/layout_bytes.hpp"
#include "core/errors.hpp"
#include "voxel_dag/dag.hpp"
#include <algorithm>
#include <numeric>

namespace tyndall::baselines {
class HalfWordDag {
public:
    static constexpr std::uint32_t near_bits = 13, far_bits = 29;
    static constexpr std::uint64_t near_end = std::uint64_t{1} << near_bits;

    /// Level and root's tag, 4 bytes each; per level of nodes, from the lowest, its first half-word, 4 bytes; the number of
    /// leaves; nodes level by level; and, from a multiple of 8 on, the leaves.
    [[nodiscard]] static Bytes encode(const voxel_dag::Dag& dag) {
        require(dag.symmetry != voxel_dag::Symmetry::Cube, "a reference has room for a tag of 3 bits");
        std::vector<std::uint32_t> order = by_falling_use(dag, 0); // of the level at work
        Bytes leaves, bytes;
        std::vector<std::uint64_t> offsets(dag.leaves.size()); // of nodes of the level below, in its words
        for (std::uint32_t rank = 0; rank < order.size(); ++rank) {
            append(leaves, dag.leaves[order[rank]]);
            offsets[order[rank]] = rank;
        }
        append(bytes, dag.level);
        append(bytes, std::uint32_t{dag.root_tag});
        std::vector<std::uint16_t> half_words;
        for (std::size_t i = 0; i < dag.levels.size(); ++i) {
            append(bytes, static_cast<std::uint32_t>(half_words.size()));
            order = by_falling_use(dag, i + 1);
            std::vector<std::uint64_t> here(order.size());
            const std::size_t first = half_words.size();
            for (const std::uint32_t node : order) {
                here[node] = half_words.size() - first;
                write_node(dag.levels[i], node, offsets, half_words);
            }
            offsets = std::move(here);
        }
        append(bytes, static_cast<std::uint32_t>(dag.leaves.size()));
        for (const std::uint16_t half_word : half_words)
            append(bytes, half_word);
        bytes.resize((bytes.size() + 7) / 8 * 8);
        bytes.insert(bytes.end(), leaves.begin(), leaves.end());
        return bytes;
    }

    explicit HalfWordDag(Bytes bytes)
        : level(number_at<std::uint32_t>(bytes, 0)), root_tag(number_at<std::uint32_t>(bytes, 4)),
          bytes_(std::move(bytes)) {
        std::size_t at = 8;
        for (std::uint32_t i = voxel_dag::leaf_level + 1; i <= level && bytes_.size() > 16; ++i, at += 4)
            begins_[i] = number_at<std::uint32_t>(bytes_, at);
        leaf_count_ = number_at<std::uint32_t>(bytes_, at);
        half_words_ = reinterpret_cast<const std::uint16_t*>(bytes_.data() + at + 4);
        leaves_ = reinterpret_cast<const std::uint64_t*>(bytes_.data() + bytes_.size()) - leaf_count_;
    }
    HalfWordDag(const HalfWordDag&) = delete;
    HalfWordDag& operator=(const HalfWordDag&) = delete;
    [[nodiscard]] bool is_empty() const { return leaf_count_ == 0; }
    [[nodiscard]] std::uint64_t byte_count() const { return bytes_.size(); }

    struct Place {
        std::uint32_t offset = 0, turn = 0; ///< In words of its level.
    };
    struct Open {
        std::uint32_t child_mask, codes;
        const std::uint16_t* references;
    };
    struct Leaf {
        std::uint64_t mask = 0;
        std::uint32_t turn = 0;
    };
    [[nodiscard]] Open open_at(std::uint32_t at_level, std::uint32_t offset) const {
        const std::uint16_t* const node = half_words_ + begins_[at_level] + offset;
        std::uint32_t there = (*node | *node >> 1) & 0x5555u; // every other bit, which are put together
        there = (there | there >> 1) & 0x3333u;
        there = (there | there >> 2) & 0x0f0fu;
        return {(there | there >> 4) & 0xffu, *node, node + 1};
    }
    [[nodiscard]] std::uint64_t leaf_at(std::uint32_t offset) const { return leaves_[offset]; }

    std::uint32_t level, root_tag;

private:
    /// Of leaves, or of levels[i - 1].
    static std::vector<std::uint32_t> by_falling_use(const voxel_dag::Dag& dag, std::size_t i) {
        std::vector<std::uint32_t> uses(i == 0 ? dag.leaves.size() : dag.levels[i - 1].node_count(), 0);
        if (i < dag.levels.size())
            for (const std::uint32_t child : dag.levels[i].children)
                ++uses[child];
        std::vector<std::uint32_t> order(uses.size());
        std::iota(order.begin(), order.end(), 0u);
        std::ranges::stable_sort(order, std::greater(), [&](std::uint32_t node) { return uses[node]; });
        return order;
    }
    static void write_node(const voxel_dag::DagLevel& nodes, std::size_t node,
                           const std::vector<std::uint64_t>& offsets, std::vector<std::uint16_t>& out) {
        const std::size_t head = out.size();
        std::uint32_t codes = 0;
        out.push_back(0);
        for (std::uint32_t octant = 0; octant < 8; ++octant) {
            if ((nodes.child_masks[node] >> octant & 1) == 0)
                continue;
            const std::size_t reference = nodes.reference(node, octant);
            const std::uint64_t offset = offsets[nodes.children[reference]];
            const std::uint32_t tag = nodes.tag(reference);
            require(offset >> (far_bits + 1) == 0, "a level of more than 2^30 words");
            if (offset < near_end) {
                codes |= 1u << 2 * octant;
                out.push_back(static_cast<std::uint16_t>(offset | tag << near_bits));
                continue;
            }
            codes |= (2u + static_cast<std::uint32_t>(offset >> far_bits)) << 2 * octant;
            const auto word =
                static_cast<std::uint32_t>((offset & ((1u << far_bits) - 1)) | std::uint64_t{tag} << far_bits);
            out.push_back(static_cast<std::uint16_t>(word));
            out.push_back(static_cast<std::uint16_t>(word >> 16));
        }
        out[head] = static_cast<std::uint16_t>(codes);
    }

    Bytes bytes_;
    std::array<std::uint32_t, voxel_dag::most_level + 1> begins_{}; ///< By level, in half-words.
    const std::uint16_t* half_words_ = nullptr;
    const std::uint64_t* leaves_ = nullptr;
    std::uint32_t leaf_count_ = 0;
};

inline HalfWordDag::Place root_of(const HalfWordDag& dag) { return {0, dag.root_tag}; }
inline HalfWordDag::Open opened(const HalfWordDag& dag, std::uint32_t level, const HalfWordDag::Place& place) {
    return dag.open_at(level, place.offset);
}
inline HalfWordDag::Place child_of(const HalfWordDag&, std::uint32_t, const HalfWordDag::Place& place,
                                   const HalfWordDag::Open& open, std::uint32_t octant) {
    const std::uint32_t before = open.codes & ((1u << 2 * octant) - 1), code = open.codes >> 2 * octant & 3;
    const std::uint32_t there = (before | before >> 1) & 0x5555u, far = before >> 1 & 0x5555u;
    const std::uint16_t* const reference = open.references + std::popcount(there) + std::popcount(far);
    if (code == 1)
        return {*reference & ((1u << HalfWordDag::near_bits) - 1), place.turn ^ *reference >> HalfWordDag::near_bits};
    const std::uint32_t word = reference[0] | std::uint32_t{reference[1]} << 16;
    return {(word & ((1u << HalfWordDag::far_bits) - 1)) | (code & 1) << HalfWordDag::far_bits,
            place.turn ^ word >> HalfWordDag::far_bits};
}
inline HalfWordDag::Leaf leaf_of(const HalfWordDag& dag, const HalfWordDag::Place& place) {
    return {dag.leaf_at(place.offset), place.turn};
}
inline std::uint32_t groups_of(const HalfWordDag::Leaf& leaf) { return voxel_dag::occupied_bytes(leaf.mask); }
inline std::uint32_t group_of(const HalfWordDag::Leaf& leaf, std::uint32_t octant) {
    return static_cast<std::uint32_t>(leaf.mask >> 8 * octant & 0xff);
}
} // namespace tyndall::baselines
