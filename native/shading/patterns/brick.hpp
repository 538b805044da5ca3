// SPDX-License-Identifier: GPL-3.0-or-later
// The Brick node: rows of bricks in mortar, each with a tint of its own.
// Based on: running bond; the tint is the integer noise of Hugo Elias' pages on Perlin noise (1998), by row and brick.
// Differs:  every so many rows bricks have another width, and every so many begin later; mortar ends by a smooth step.
#pragma once
#include "core/math.hpp"
#include <cstdint>

namespace tyndall::patterns {
struct BrickConfig {
    float scale = 5.0f, mortar_size = 0.02f, mortar_smooth = 0.1f, bias = 0.0f, brick_width = 0.5f, row_height = 0.25f;
    float offset = 0.5f, squash = 1.0f;
    int offset_frequency = 2, squash_frequency = 2;
};
struct Brick {
    float tint;         ///< [0, 1], of the whole brick
    float mortar_share; ///< [0, 1]
};
[[nodiscard]] Brick brick(const vec3& vector, const BrickConfig& config);
} // namespace tyndall::patterns
