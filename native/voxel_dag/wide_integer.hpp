// SPDX-License-Identifier: GPL-3.0-or-later
// Integers of 128 bits, which GCC and Clang have beyond the standard.
#pragma once
namespace tyndall::voxel_dag {
__extension__ typedef __int128 Int128; // no alias declaration: -Wpedantic takes __extension__ before a typedef alone

/// Rounded down; denominator > 0.
template <typename Integer>
[[nodiscard]] constexpr Integer floor_of_quotient(Integer numerator, Integer denominator) {
    return numerator / denominator - Integer{numerator % denominator < 0};
}
} // namespace tyndall::voxel_dag
