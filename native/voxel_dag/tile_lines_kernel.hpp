// SPDX-License-Identifier: GPL-3.0-or-later
// The lines of tile_lines.hpp for triangles near their tile, one in each lane of a vector.
// Differs:  from lay_lines() in nothing that a scan sees. What three coordinates below 2^16 steps are multiplied and added
//           up to are whole numbers below 2^53, which doubles hold.
// Bound:    about 450 vector operations and 11 divisions per block.
#pragma once
#include "voxel_dag/tile_lines.hpp"
#include <span>

namespace tyndall::voxel_dag {
/// Coordinates, in steps from the lower corner of the tile, stay below.
inline constexpr std::int64_t most_near = std::int64_t{1} << 16;

/// corner[i][axis] of each lane's triangle; lanes that no triangle is in have to be finite.
struct alignas(64) NearTriangles {
    std::array<std::array<Lanes, 3>, 3> corner{};
};
/// Of all blocks together, see seen_along_axes().
[[nodiscard]] std::array<double, 3> seen_along_axes(std::span<const NearTriangles> blocks);
/// By the widest vectors of this CPU (core/simd.hpp). The frame's corner is not asked for.
void lay_near_lines(std::span<const NearTriangles> blocks, const TileFrame& frame, std::span<TileLines> lines);
} // namespace tyndall::voxel_dag
