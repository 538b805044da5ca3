// SPDX-License-Identifier: GPL-3.0-or-later
// Voxels in a list of any order, with what each row of it carries.
#pragma once
#include "core/math.hpp"
#include "core/progress.hpp"
#include "voxel_dag/leaf_masks.hpp"
#include "voxel_dag/voxel_attributes.hpp"
#include <span>

namespace tyndall::voxel_dag {
/// Per row of the list, or nothing.
struct ListedAttributes {
    std::span<const ByteColor> colors;
    std::span<const vec3> normals; ///< Of any length but 0.
    struct Channel {
        std::string name;
        std::span<const std::uint8_t> values;
    };
    std::vector<Channel> channels;
};
struct ListedVoxels {
    LeafMasks leaves;
    VoxelAttributes attributes;
};
/// Of a voxel that is listed more than once, the last row counts: what a later stroke paints. Throws InvalidInput, which
/// names the first voxel beyond the resolution, the first normal that has no direction, or an array of another length; and
/// Cancelled.
[[nodiscard]] ListedVoxels voxels_of_list(std::span<const Voxel> voxels, const ListedAttributes& attributes,
                                          std::uint32_t level, const Progress& progress);
} // namespace tyndall::voxel_dag
