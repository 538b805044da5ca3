// SPDX-License-Identifier: GPL-3.0-or-later
// A tile's runs of bits become bricks of 4^3 in Morton order, and the tile is empty again.
// Based on: Warren, Hacker's Delight, section 7-3: bit matrices are transposed by swapping halves.
// Differs:  in as many dimensions as there are index bits: those of a place in a word are exchanged for those of one of
//           the sixteen words around a brick, 16 bricks per lane at a time. Nothing is sorted.
// Bound:    2.5 vector operations per lane and brick of the tile, and 10 cycles for each brick that is not empty.
#pragma once
#include "voxel_dag/tile.hpp"

namespace tyndall::voxel_dag {
inline constexpr std::uint32_t tile_bricks = 1u << 3 * (tile_level - leaf_level);

/// Brick i of the tile, by Morton code, where bit i % 64 of is_full[i / 64] is set; others hold anything.
struct Bricks {
    alignas(64) std::array<std::uint64_t, tile_bricks> masks;
    std::array<std::uint64_t, tile_bricks / 64> is_full;
};
/// By the widest vectors of this CPU (core/simd.hpp); the bits are the same with each.
void take_bricks(TileBits& bits, const ScanAxes& axes, Bricks& bricks);
} // namespace tyndall::voxel_dag
