// SPDX-License-Identifier: GPL-3.0-or-later
// Slope rows that rays fill: where a scene has many more triangles than rows have samples, one ray per sample, from the
// light to the first occluder, takes less time than to place each triangle. A sample holds what it would of the raster.
// Bound:    0.3 us per sample in a hall and 3 among a million leaves, in packets of 16 along a row, beside 13 to 77 ns per
//           triangle that is placed (without AVX-512).
#pragma once
#include "light_shafts/occluders.hpp"
#include "light_shafts/slope_rows.hpp"

namespace tyndall::light_shafts::slope_rows {
/// Whether rays are the cheaper way, and may answer for the occluders at all: `occluders` are whole.
[[nodiscard]] bool are_better_traced(const Rows& rows, const Occluders& occluders);
/// Fills all rows by rays of the scene that the occluders, which are whole, were gathered of. Throws Cancelled.
void trace(Rows& rows, const Scene& scene, const Progress& progress);
/// Fills all rows, by whichever takes less time. Throws Cancelled.
void fill(Rows& rows, const Scene& scene, const Occluders& occluders, const Progress& progress);
} // namespace tyndall::light_shafts::slope_rows
