// SPDX-License-Identifier: GPL-3.0-or-later
// Shares of a cube's sides that its voxels cover, seen along each axis: from bits, and as 24 bits.
// Bound:    7 bits keep the root of a share: within 0.8 % of the side, and within 8 % of the share itself at 0.002.
#pragma once
#include "voxel_dag/cube_group.hpp"
#include <algorithm>
#include <bit>
#include <cmath>

namespace tyndall::voxel_dag {
/// 7 bits per axis, x in the lowest: 127 times the root of the share. What is there never becomes 0. Bit 21: seen along
/// some axis, most of what is covered is wide: part of a sheet, not of wires or of a sieve.
using AxisShares = std::uint32_t;
inline constexpr std::uint32_t share_bits = 7, full_share = (1u << share_bits) - 1;
inline constexpr AxisShares full_shares = (1u << 3 * share_bits) - 1, is_sheet = 1u << 3 * share_bits;

[[nodiscard]] inline AxisShares axis_shares(const std::array<double, 3>& shares) {
    AxisShares packed = 0;
    for (std::uint32_t axis = 0; axis < 3; ++axis)
        if (shares[axis] > 0.0)
            packed |= static_cast<AxisShares>(
                          std::clamp<long>(std::lround(full_share * std::sqrt(shares[axis])), 1, full_share))
                      << share_bits * axis;
    return packed;
}
/// Of an axis.
[[nodiscard]] constexpr double share_along(AxisShares shares, std::uint32_t axis) {
    const auto root = static_cast<double>(shares >> share_bits * axis & full_share);
    return root * root / (full_share * full_share);
}
[[nodiscard]] constexpr bool covers_all(AxisShares shares) { return (shares & full_shares) == full_shares; }

/// Where elements of the cube's symmetries take each axis.
inline constexpr std::array<std::array<std::uint8_t, 3>, cube_element_count> turned_axes = [] {
    std::array<std::array<std::uint8_t, 3>, cube_element_count> axes{};
    for (std::uint32_t element = 0; element < cube_element_count; ++element)
        for (std::uint32_t axis = 0; axis < 3; ++axis)
            axes[element][axis] = static_cast<std::uint8_t>(std::countr_zero(
                static_cast<std::uint32_t>(cube_group.octant[element][1u << axis] ^ cube_group.octant[element][0])));
    return axes;
}();
[[nodiscard]] constexpr AxisShares turned_shares(std::uint32_t element, AxisShares shares) {
    AxisShares turned = shares & is_sheet;
    for (std::uint32_t axis = 0; axis < 3; ++axis)
        turned |= (shares >> share_bits * axis & full_share) << share_bits * turned_axes[element][axis];
    return turned;
}

/// The silhouette of a brick along an axis: bits of its 16 columns, where their lowest voxels are.
[[nodiscard]] constexpr std::uint64_t flattened(std::uint64_t brick, std::uint32_t axis) {
    constexpr std::array<std::uint64_t, 6> without_digit = [] {
        std::array<std::uint64_t, 6> masks{};
        for (std::uint32_t digit = 0; digit < 6; ++digit)
            for (std::uint32_t i = 0; i < 64; ++i)
                masks[digit] |= std::uint64_t{(i >> digit & 1) == 0} << i;
        return masks;
    }();
    brick = (brick | brick >> (1u << axis)) & without_digit[axis];
    return (brick | brick >> (8u << axis)) & without_digit[axis + 3];
}

/// Whether at least half of the places that a silhouette covers lie in squares of 2 x 2 of them. Bit u + side * v.
template <std::uint32_t side>
[[nodiscard]] constexpr bool is_wide(std::uint64_t places) {
    constexpr std::uint64_t not_last = [] {
        std::uint64_t bits = 0;
        for (std::uint32_t i = 0; i < side * side; ++i)
            bits |= std::uint64_t{i % side != side - 1} << i;
        return bits;
    }();
    const std::uint64_t rows = places & places >> 1 & not_last, squares = rows & rows >> side;
    const std::uint64_t pairs = squares | squares << 1;
    return 2 * std::popcount(pairs | pairs << side) >= std::popcount(places);
}
/// A flattened brick's columns, row by row: bit u + 4 * v, u along the lower one of the other axes.
[[nodiscard]] constexpr std::uint64_t rows_of(std::uint64_t flat, std::uint32_t axis) {
    const std::uint32_t low = axis == 0 ? 1 : 0, high = axis == 2 ? 1 : 2;
    std::uint64_t rows = 0;
    for (std::uint32_t v = 0; v < 4; ++v)
        for (std::uint32_t u = 0; u < 4; ++u)
            rows |=
                (flat >> (((u & 1) << low) + ((v & 1) << high) + ((u >> 1) << (low + 3)) + ((v >> 1) << (high + 3))) &
                 1)
                << (u + 4 * v);
    return rows;
}

/// Of 4 x 4 x 4 voxels.
[[nodiscard]] inline AxisShares shares_of_brick(std::uint64_t brick) {
    std::array<double, 3> shares;
    bool has_sheet = false;
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
        const std::uint64_t flat = flattened(brick, axis);
        shares[axis] = std::popcount(flat) / 16.0;
        has_sheet |= is_wide<4>(rows_of(flat, axis));
    }
    return axis_shares(shares) | (has_sheet ? is_sheet : 0);
}
} // namespace tyndall::voxel_dag
