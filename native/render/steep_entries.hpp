// SPDX-License-Identifier: GPL-3.0-or-later
// Functions with edges draw lines through pixels: where a parameter changes within a pixel by more than a function's
// texel, its entry is split into four, at the parameters that its quarters have.
// Based on: rotated grid supersampling; the slope is limited as in van Leer, Towards the Ultimate Conservative Difference
//           Scheme V, J. Comput. Phys. 32, 1979 (minmod).
// Differs:  only between pixels that see the same surface. The limiter leaves noise and true steps alone, which a plain
//           difference would smear.
// Bound:    3 differences per function and entry; entries that stay whole are copied. At most 4 times the memory.
#pragma once
#include "core/progress.hpp"
#include "render/styled_shafts.hpp"
#include <span>

namespace tyndall::render {
/// Surfaces whose depths differ by less are one: a floor that leads away is, a branch before a wall is not. Relative.
inline constexpr double same_surface = 0.1;
/// 0 for equal depths, 1 for very different ones; the sky, 0, is far from everything, but least from what is farthest.
[[nodiscard]] double depth_difference(float a_m, float b_m);

/// `depth_m`: of each entry's surface. `width`: of the picture.
[[nodiscard]] UnstyledFilm::Entries split_steep(UnstyledFilm::Entries entries, std::span<const float> depth_m,
                                                std::uint32_t width, std::size_t pixel_count, const Progress& progress);
} // namespace tyndall::render
