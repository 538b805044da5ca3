// SPDX-License-Identifier: GPL-3.0-or-later
// From a DAG back to the voxels that it was made of, in Morton order, a part at a time.
// Bound:    one step per node and brick of the tree; memory for one part.
#pragma once
#include "core/progress.hpp"
#include "voxel_dag/dag.hpp"
#include <array>
#include <functional>

namespace tyndall::voxel_dag {
/// Hands out the bricks of a DAG, which must outlive it and be usable: see require_usable().
class Decoder {
public:
    explicit Decoder(const Dag& dag);
    /// The next bricks, at most so many, at least one; false, and none, where all have been handed out.
    bool next(std::size_t most_bricks, LeafMasks& part);

private:
    /// A node on the way down, and the next of its octants, as they lie in the world.
    struct Step {
        std::uint64_t code;
        std::uint32_t node, turn, octant;
    };
    void add(std::uint64_t code, std::uint32_t leaf, std::uint32_t turn, LeafMasks& part) const;

    const Dag& dag_;
    std::array<Step, most_level - leaf_level> steps_;
    std::size_t depth_; ///< levels[depth_ - 1] is at work; 0: the root is a leaf.
    bool is_done_;
};

/// Calls receive with one part after another: at least one brick each, and at most part_size. A DAG that is not usable
/// (require_usable()) is no input. Throws Cancelled.
void decode(const Dag& dag, std::size_t part_size, const std::function<void(const LeafMasks& part)>& receive,
            const Progress& progress);
/// All at once.
[[nodiscard]] LeafMasks decode(const Dag& dag, const Progress& progress);
} // namespace tyndall::voxel_dag
