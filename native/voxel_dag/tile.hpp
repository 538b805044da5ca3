// SPDX-License-Identifier: GPL-3.0-or-later
// 64^3 bits that triangles are drawn into: runs of voxels along one axis are runs of bits in one word.
#pragma once
#include "voxel_dag/leaf_masks.hpp"
#include <array>

namespace tyndall::voxel_dag {
inline constexpr std::uint32_t tile_level = 6; ///< A tile has 2^6 cells a side.
inline constexpr std::uint32_t tile_side = 1u << tile_level;

/// Which axis of the world (0, 1, 2: x, y, z) is which axis of a scan. All three differ.
struct ScanAxes {
    std::uint32_t run;   ///< Along a word's bits.
    std::uint32_t row;   ///< Side by side in a vector's lanes.
    std::uint32_t depth; ///< One after the other.
};

/// A word lies where the lowest two bits of its two coordinates, above the other four of each, say: vectors then hold
/// what becomes the same place of many bricks (tile_bricks.cpp). The earlier axis of x, y and z has the lower bits.
struct WordPlace {
    int low_shift, high_shift;
    [[nodiscard]] constexpr std::uint32_t of(std::uint32_t at) const {
        return (at & 3) << low_shift | (at >> 2) << high_shift;
    }
    /// What of() gave, of a whole place.
    [[nodiscard]] constexpr std::uint32_t at(std::uint64_t place) const {
        return static_cast<std::uint32_t>((place >> low_shift & 3) | (place >> high_shift & 15) << 2);
    }
};
inline constexpr WordPlace lower_place{8, 0}, upper_place{10, 4};
[[nodiscard]] constexpr WordPlace row_place(const ScanAxes& axes) {
    return axes.row < axes.depth ? lower_place : upper_place;
}
[[nodiscard]] constexpr WordPlace depth_place(const ScanAxes& axes) {
    return axes.row < axes.depth ? upper_place : lower_place;
}

struct alignas(64) TileBits {
    std::array<std::uint64_t, tile_side * tile_side> words{};
};
} // namespace tyndall::voxel_dag
