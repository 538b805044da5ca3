// SPDX-License-Identifier: GPL-3.0-or-later
// Voxels as bricks of 4 x 4 x 4, 64 bits each: what voxelizers make and DAGs are built of.
// Bound:    16 bytes per brick; a surface has about 10 voxels in each.
#pragma once
#include "voxel_dag/morton.hpp"
#include <vector>

namespace tyndall::voxel_dag {
inline constexpr std::uint32_t leaf_level = 2;  ///< A leaf has 2^2 voxels a side.
inline constexpr std::uint32_t most_level = 17; ///< 131,072 voxels a side.

/// Bricks that have any voxel. Two sets of the same voxels are equal, bit by bit.
struct LeafMasks {
    std::uint32_t level = leaf_level; ///< 2^level voxels a side, in [leaf_level, most_level].
    std::vector<std::uint64_t> codes; ///< Morton codes of the bricks, ascending.
    std::vector<std::uint64_t> masks; ///< As many, none of them 0; bit i: the voxel of Morton code i in its brick.

    bool operator==(const LeafMasks&) const = default;
    [[nodiscard]] std::uint64_t resolution() const { return std::uint64_t{1} << level; }
    [[nodiscard]] std::uint64_t voxel_count() const;
    [[nodiscard]] bool contains(const Voxel& voxel) const;
};

/// The octants of a brick that have any voxel. Bit i: byte i is not 0.
[[nodiscard]] constexpr std::uint32_t occupied_bytes(std::uint64_t brick) {
    constexpr std::uint64_t low = 0x7f7f7f7f7f7f7f7full;
    const std::uint64_t high = (((brick & low) + low) | brick) & ~low;
    return static_cast<std::uint32_t>((high >> 7) * 0x0102040810204080ull >> 56);
}

/// Throws InvalidInput, which names the first brick that is wrong.
void require_usable(const LeafMasks& leaves);
/// Of voxels in any order, that may repeat. Throws InvalidInput, which names one beyond the resolution.
[[nodiscard]] LeafMasks leaf_masks_of(std::vector<Voxel> voxels, std::uint32_t level);
} // namespace tyndall::voxel_dag
