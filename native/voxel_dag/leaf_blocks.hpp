// SPDX-License-Identifier: GPL-3.0-or-later
// Voxels as blocks of 8 x 8 x 8 bits in the order in which OpenVDB has them, for grids that come from there or go there.
// Bound:    76 bytes per block; 64 steps per brick.
#pragma once
#include "core/progress.hpp"
#include "voxel_dag/leaf_masks.hpp"
#include <span>

namespace tyndall::voxel_dag {
inline constexpr std::uint32_t block_level = 3; ///< A block has 2^3 voxels a side.

/// Bit 8 y + z of word x. As bytes, little-endian: bit z of byte 8 x + y.
using BlockBits = std::array<std::uint64_t, 8>;
struct LeafBlocks {
    std::vector<Voxel> origins; ///< Lowest voxel of each, multiples of 8.
    std::vector<BlockBits> bits;
};
/// Blocks in any order; they may be empty. Throws InvalidInput, which names the first one that lies elsewhere than at
/// multiples of 8 below 2^level, or twice; and Cancelled.
[[nodiscard]] LeafMasks leaf_masks_of(std::span<const Voxel> origins, std::span<const BlockBits> bits,
                                      std::uint32_t level, const Progress& progress);
/// In Morton order. Throws Cancelled.
[[nodiscard]] LeafBlocks leaf_blocks_of(const LeafMasks& leaves, const Progress& progress);
} // namespace tyndall::voxel_dag
