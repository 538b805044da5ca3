// SPDX-License-Identifier: GPL-3.0-or-later
// What voxels carry beside being there: what voxelizers make of a mesh's surface, and what DAGs keep.
// Bound:    4 bytes per voxel and colour or normal, 1 per channel.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace tyndall::voxel_dag {
using ByteColor = std::array<std::uint8_t, 3>; ///< Of sRGB's curve.
/// A further value of 8 bits: roughness, metallic, emission, reflectance, or whatever else a script names.
struct VoxelChannel {
    std::string name;
    std::vector<std::uint8_t> values; ///< One per voxel.

    bool operator==(const VoxelChannel&) const = default;
};
/// Each array has one entry per voxel, in Morton order, or none at all.
struct VoxelAttributes {
    static constexpr std::size_t most_channels = 4;

    std::vector<std::uint32_t> colors;  ///< Of sRGB's curve, 8 bits each: r + 2^8 g + 2^16 b.
    std::vector<std::uint32_t> normals; ///< octahedral::encode() in 32 bits; the world's axes.
    std::vector<VoxelChannel> channels; ///< At most most_channels, of different names.

    bool operator==(const VoxelAttributes&) const = default;
    [[nodiscard]] bool is_empty() const { return colors.empty() && normals.empty() && channels.empty(); }
};
} // namespace tyndall::voxel_dag
