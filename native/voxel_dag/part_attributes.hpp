// SPDX-License-Identifier: GPL-3.0-or-later
// What the voxels of one sub-cube carry, and the means of its larger nodes, in the order in which they lie in the world:
// what a part's file holds until the stored order of the whole is known.
// Bound:    while it is made, what given_materials.hpp says, and 100 bytes per node of 16^3.
#pragma once
#include "voxel_dag/given_materials.hpp"
#include "voxel_dag/leaf_masks.hpp"

namespace tyndall::voxel_dag {
struct PartAttributes {
    CountedMaterials materials;             ///< Colours as they were given; normals as they are kept.
    std::vector<std::uint8_t> indices;      ///< A run array: the number of each voxel's material, in Morton order.
    CountedMaterials means;                 ///< Different ones.
    std::vector<std::uint8_t> mean_indices; ///< Likewise, of nodes of 16^3 and more, each before its children.
    SampleSum sum;                          ///< Of all voxels.
    NormalErrors normals;

    [[nodiscard]] bool is_empty() const { return indices.empty(); }
};
/// Of the voxels of `leaves`, one at least. Throws InvalidInput where the budget does not suffice, and Cancelled.
[[nodiscard]] PartAttributes part_attributes(const LeafMasks& leaves, const VoxelAttributes& attributes,
                                             const AttributeConfig& config, const Progress& progress);
} // namespace tyndall::voxel_dag
