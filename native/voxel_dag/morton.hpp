// SPDX-License-Identifier: GPL-3.0-or-later
// Morton codes: the bits of x, y and z in turns, those of x lowest.
// Based on: Morton, A Computer Oriented Geodetic Data Base, IBM 1966.
#pragma once
#include <array>
#include <cstdint>

namespace tyndall::voxel_dag {
using Voxel = std::array<std::uint32_t, 3>; ///< x, y, z; below the resolution.

/// Bit i of the lowest 21 goes to bit 3 * i.
[[nodiscard]] constexpr std::uint64_t spread_bits(std::uint32_t value) {
    std::uint64_t bits = value & 0x1fffffu;
    bits = (bits | bits << 32) & 0x001f00000000ffffull;
    bits = (bits | bits << 16) & 0x001f0000ff0000ffull;
    bits = (bits | bits << 8) & 0x100f00f00f00f00full;
    bits = (bits | bits << 4) & 0x10c30c30c30c30c3ull;
    return (bits | bits << 2) & 0x1249249249249249ull;
}
/// What spread_bits() gave back.
[[nodiscard]] constexpr std::uint32_t gather_bits(std::uint64_t bits) {
    bits &= 0x1249249249249249ull;
    bits = (bits | bits >> 2) & 0x10c30c30c30c30c3ull;
    bits = (bits | bits >> 4) & 0x100f00f00f00f00full;
    bits = (bits | bits >> 8) & 0x001f0000ff0000ffull;
    bits = (bits | bits >> 16) & 0x001f00000000ffffull;
    return static_cast<std::uint32_t>((bits | bits >> 32) & 0x1fffffull);
}
[[nodiscard]] constexpr std::uint64_t morton_code(const Voxel& voxel) {
    return spread_bits(voxel[0]) | spread_bits(voxel[1]) << 1 | spread_bits(voxel[2]) << 2;
}
[[nodiscard]] constexpr Voxel voxel_at(std::uint64_t code) {
    return Voxel{gather_bits(code), gather_bits(code >> 1), gather_bits(code >> 2)};
}
} // namespace tyndall::voxel_dag
