// SPDX-License-Identifier: GPL-3.0-or-later
// All voxels of any layout, in Morton order.
#pragma once
#include "voxel_dag/cube_group.hpp"
#include "voxel_dag/leaf_masks.hpp"

namespace tyndall::baselines {
template <class Tree, class Place>
void add_bricks(const Tree& tree, std::uint32_t level, std::uint64_t code, const Place& place,
                voxel_dag::LeafMasks& voxels) {
    if (level == voxel_dag::leaf_level) {
        const auto leaf = leaf_of(tree, place);
        std::uint64_t mask = 0;
        for (std::uint32_t octant = 0; octant < 8; ++octant)
            if ((groups_of(leaf) >> octant & 1) != 0)
                mask |= std::uint64_t{group_of(leaf, octant)} << 8 * octant;
        voxels.codes.push_back(code);
        voxels.masks.push_back(voxel_dag::turned_leaf(leaf.turn, mask));
        return;
    }
    const auto open = opened(tree, level, place);
    for (std::uint32_t there = 0; there < 8; ++there) {
        const std::uint32_t octant = voxel_dag::cube_group.octant[voxel_dag::cube_group.inverse[place.turn]][there];
        if ((open.child_mask >> octant & 1) != 0)
            add_bricks(tree, level - 1, code << 3 | there, child_of(tree, level, place, open, octant), voxels);
    }
}
template <class Tree>
[[nodiscard]] voxel_dag::LeafMasks decoded_bricks(const Tree& tree) {
    voxel_dag::LeafMasks voxels{.level = tree.level, .codes = {}, .masks = {}};
    if (!tree.is_empty())
        add_bricks(tree, tree.level, 0, root_of(tree), voxels);
    return voxels;
}
} // namespace tyndall::baselines
