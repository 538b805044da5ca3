// SPDX-License-Identifier: GPL-3.0-or-later
// From a DAG back to the voxels that it was made of, in Morton order, a part at a time.
// Bound:    one step per node and brick of the tree; memory for one part.
#pragma once
#include "core/progress.hpp"
#include "voxel_dag/tree_nodes.hpp"
#include <array>
#include <functional>
#include <utility>

namespace tyndall::voxel_dag {
/// Hands out the bricks of a Dag or a PackedDag, which must outlive it and be usable: see require_usable().
template <class Tree>
class Decoder {
public:
    explicit Decoder(const Tree& tree);
    /// The next bricks, at most so many, at least one; false, and none, where all have been handed out.
    bool next(std::size_t most_bricks, LeafMasks& part);

private:
    using Place = decltype(root_of(std::declval<const Tree&>()));
    using Open = decltype(opened(std::declval<const Tree&>(), 0, Place()));
    /// A node on the way down, and the next of its octants, as they lie in the world.
    struct Step {
        std::uint64_t code;
        Place place;
        Open open;
        std::uint32_t octant;
    };
    [[nodiscard]] Step& step() { return steps_[level_ - leaf_level - 1]; }
    void enter(std::uint64_t code, const Place& place);
    void add(std::uint64_t code, const Place& place, LeafMasks& part) const;

    const Tree& tree_;
    std::array<Step, most_level - leaf_level> steps_;
    std::uint32_t level_; ///< Of the node at work.
    bool is_done_;
};
extern template class Decoder<Dag>;
extern template class Decoder<PackedDag>;

/// Calls receive with one part after another: at least one brick each, and at most part_size. A DAG that is not usable
/// (require_usable()) is no input. Throws Cancelled.
void decode(const Dag& dag, std::size_t part_size, const std::function<void(const LeafMasks& part)>& receive,
            const Progress& progress);
void decode(const PackedDag& dag, std::size_t part_size, const std::function<void(const LeafMasks& part)>& receive,
            const Progress& progress);
/// All at once.
[[nodiscard]] LeafMasks decode(const Dag& dag, const Progress& progress);
} // namespace tyndall::voxel_dag
