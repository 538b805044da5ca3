// SPDX-License-Identifier: GPL-3.0-or-later
// The Checker node: cubes of two kinds.
// Based on: the parity of three whole numbers.
// Differs:  places are shrunk by a millionth, towards the positive, as Cycles does: a plane at 0 or 1 is not torn
//           between two kinds by rounding.
#pragma once
#include "core/math.hpp"

namespace tyndall::patterns {
/// Whole numbers of cells or turns: where surfaces like to lie, and rounding must not choose a side.
[[nodiscard]] inline vec3 off_whole_numbers(const vec3& place) { return (place + 0.000001f) * 0.999999f; }

/// Whether the node's first colour is here.
[[nodiscard]] inline bool checker(const vec3& vector, float scale) {
    const vec3 cell = glm::floor(off_whole_numbers(vector * scale));
    return std::fmod(cell.x + cell.y + cell.z, 2.0f) != 0.0f;
}
} // namespace tyndall::patterns
