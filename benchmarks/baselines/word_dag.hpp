// SPDX-License-Identifier: GPL-3.0-or-later
// A DAG in words of 32 bits: SVDAG, and USSVDAG where it has reflections.
// Based on: Kämpe, Sintorn, Assarsson, High Resolution Sparse Voxel DAGs, 2013, section 4: a word with the child mask, and
//           one per child; Jaspe, dissertation 2018, 5.6.3: 3 bits per octant of that first word's padding say how its
//           child is mirrored. 2 x 2 x 2 voxels are a word, which all that have the same share.
// Differs:  the root has a tag, too. References are places from the file's beginning, in words.
// Bound:    8 to 36 bytes per node.
#pragma once
#include "baselines/layout_bytes.hpp"
#include "core/errors.hpp"
#include "voxel_dag/cube_group.hpp"
#include "voxel_dag/dag.hpp"
#include <array>

namespace tyndall::baselines {
class WordDag {
public:
    /// Level, root's tag, root's place, each a word; groups of 8 voxels; nodes of 4 x 4 x 4, and so on up.
    [[nodiscard]] static Bytes encode(const voxel_dag::Dag& dag) {
        require(dag.symmetry != voxel_dag::Symmetry::Cube, "a word has room for tags of 3 bits");
        std::vector<std::uint32_t> words{dag.level, dag.root_tag, 0};
        std::array<std::uint32_t, 256> group_at{};
        for (const std::uint64_t leaf : dag.leaves)
            for (std::uint32_t octant = 0; octant < 8; ++octant)
                if (const std::uint32_t group = leaf >> 8 * octant & 0xff; group != 0 && group_at[group] == 0) {
                    group_at[group] = static_cast<std::uint32_t>(words.size());
                    words.push_back(group);
                }
        std::vector<std::uint32_t> below; // where each node of the level below lies
        for (const std::uint64_t leaf : dag.leaves) {
            below.push_back(static_cast<std::uint32_t>(words.size()));
            words.push_back(voxel_dag::occupied_bytes(leaf));
            for (std::uint32_t octant = 0; octant < 8; ++octant)
                if (const std::uint32_t group = leaf >> 8 * octant & 0xff; group != 0)
                    words.push_back(group_at[group]);
        }
        for (const voxel_dag::DagLevel& nodes : dag.levels) {
            std::vector<std::uint32_t> here;
            for (std::size_t node = 0; node < nodes.node_count(); ++node) {
                const std::size_t first = words.size();
                here.push_back(static_cast<std::uint32_t>(first));
                words.push_back(nodes.child_masks[node]);
                for (std::uint32_t octant = 0; octant < 8; ++octant)
                    if ((nodes.child_masks[node] >> octant & 1) != 0) {
                        const std::size_t reference = nodes.reference(node, octant);
                        words[first] |= std::uint32_t{nodes.tag(reference)} << (8 + 3 * octant);
                        words.push_back(below[nodes.children[reference]]);
                    }
            }
            below = std::move(here);
        }
        words[2] = below.empty() ? 0 : below.front();
        Bytes bytes(4 * words.size());
        std::memcpy(bytes.data(), words.data(), bytes.size());
        return bytes;
    }

    explicit WordDag(const Bytes& bytes) : words_(bytes.size() / 4) {
        std::memcpy(words_.data(), bytes.data(), bytes.size());
        level = words_[0];
    }
    [[nodiscard]] bool is_empty() const { return words_[2] == 0; }
    [[nodiscard]] std::uint64_t byte_count() const { return 4 * words_.size(); }
    [[nodiscard]] const std::uint32_t* words() const { return words_.data(); }

    struct Place {
        std::uint32_t word = 0, turn = 0;
    };
    struct Open {
        std::uint32_t child_mask, tags, word;
    };
    struct Leaf {
        const std::uint32_t* words = nullptr;
        std::uint32_t word = 0, turn = 0;
    };
    std::uint32_t level;

private:
    std::vector<std::uint32_t> words_; ///< The file.
};

inline WordDag::Place root_of(const WordDag& dag) { return {dag.words()[2], dag.words()[1]}; }
inline WordDag::Open opened(const WordDag& dag, std::uint32_t, const WordDag::Place& place) {
    const std::uint32_t head = dag.words()[place.word];
    return {head & 0xff, head >> 8, place.word};
}
inline WordDag::Place child_of(const WordDag& dag, std::uint32_t, const WordDag::Place& place,
                               const WordDag::Open& open, std::uint32_t octant) {
    // Reflections are their own bits: one after another, these are exchanged.
    return {dag.words()[open.word + 1 + rank_of(open.child_mask, octant)], place.turn ^ (open.tags >> 3 * octant & 7)};
}
inline WordDag::Leaf leaf_of(const WordDag& dag, const WordDag::Place& place) {
    return {dag.words(), place.word, place.turn};
}
inline std::uint32_t groups_of(const WordDag::Leaf& leaf) { return leaf.words[leaf.word] & 0xff; }
inline std::uint32_t group_of(const WordDag::Leaf& leaf, std::uint32_t octant) {
    return leaf.words[leaf.words[leaf.word + 1 + rank_of(leaf.words[leaf.word] & 0xff, octant)]];
}
} // namespace tyndall::baselines
