// SPDX-License-Identifier: GPL-3.0-or-later
// The Magic node: sines of sines, whose signs change from level to level.
// Based on: Blender's manual (Magic Texture node: depth and distortion) and pictures of Cycles at each depth.
// Differs:  no.
#pragma once
#include "core/math.hpp"

namespace tyndall::patterns {
/// `depth` in [0, 10].
[[nodiscard]] Rgb magic(const vec3& vector, float scale, float distortion, int depth);
} // namespace tyndall::patterns
