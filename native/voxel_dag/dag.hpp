// SPDX-License-Identifier: GPL-3.0-or-later
// Voxels as a directed acyclic graph: a tree of octants in which equal subtrees are stored once.
// Based on: Kämpe, Sintorn, Assarsson, High Resolution Sparse Voxel DAGs, 2013; Jaspe, dissertation 2018, 5.3 and 5.4:
//           leaves are bricks of 4 x 4 x 4, references carry a tag that says how the child is turned.
// Differs:  a tag is any of the 48 symmetries of a cube, not reflections alone (cube_group.hpp), and the root has one.
// Bound:    5 bytes per node, 4 per reference and 1 more where it has a tag, 8 per leaf.
#pragma once
#include "voxel_dag/leaf_masks.hpp"
#include <bit>

namespace tyndall::voxel_dag {
/// What references may do to the child that they name.
enum class Symmetry : std::uint8_t {
    None,        ///< Nothing: all tags are 0.
    Reflections, ///< 8: mirror it along any axes.
    Cube,        ///< 48: exchange the axes, too.
};

/// How many elements tags are taken from: those of cube_group.hpp that are below.
[[nodiscard]] constexpr std::uint32_t symmetry_order(Symmetry symmetry) {
    return symmetry == Symmetry::None ? 1 : symmetry == Symmetry::Reflections ? 8 : 48;
}

/// The nodes of one level, in order of their numbers. Child i of a node lies in octant i: x + 2 y + 4 z.
struct DagLevel {
    std::vector<std::uint8_t> child_masks;     ///< Per node, never 0; bit i: child i is there.
    std::vector<std::uint32_t> first_children; ///< Per node, and one past: where its references begin.
    std::vector<std::uint32_t> children;       ///< Numbers in the level below, of the children that are there.
    std::vector<std::uint8_t> tags;            ///< As many, or none under Symmetry::None; see cube_group.hpp.

    bool operator==(const DagLevel&) const = default;
    [[nodiscard]] std::size_t node_count() const { return child_masks.size(); }
    /// Where the reference to child `octant`, which is there, lies in children and tags.
    [[nodiscard]] std::size_t reference(std::size_t node, std::uint32_t octant) const {
        const auto before = static_cast<std::uint32_t>(child_masks[node]) & ((1u << octant) - 1);
        return first_children[node] + static_cast<std::size_t>(std::popcount(before));
    }
    [[nodiscard]] std::uint8_t tag(std::size_t reference) const {
        return tags.empty() ? std::uint8_t{0} : tags[reference];
    }
};

/// Node 0 of the topmost level, or leaf 0 where there is no level, is the root. Without voxels nothing is there.
struct Dag {
    std::uint32_t level = leaf_level; ///< 2^level voxels a side.
    Symmetry symmetry = Symmetry::None;
    std::uint8_t root_tag = 0;
    std::vector<std::uint64_t> leaves; ///< Bit i: the voxel of Morton code i in the brick.
    std::vector<DagLevel>
        levels; ///< Nodes of 2^(3 + i) voxels a side in levels[i]; the children of levels[0] are leaves.

    bool operator==(const Dag&) const = default;
    [[nodiscard]] std::uint64_t resolution() const { return std::uint64_t{1} << level; }
    [[nodiscard]] bool is_empty() const { return leaves.empty(); }
    [[nodiscard]] std::size_t node_count() const; ///< Inner nodes and leaves.
    [[nodiscard]] std::uint64_t voxel_count() const;
    [[nodiscard]] bool contains(const Voxel& voxel) const;
};

/// Throws InvalidInput, which names the first level that is wrong: afterwards nothing that follows references leaves
/// the arrays.
void require_usable(const Dag& dag);
} // namespace tyndall::voxel_dag
