// SPDX-License-Identifier: GPL-3.0-or-later
// Flat morphology on what a light sees: maps and rows in which a larger value is nearer to the light, and -infinity is
// nothing at all. A dilation takes the largest value around, an erosion the smallest; a closing is both, one after the
// other, and fills holes that its kernel does not fit into.
// Based on: Kol, dissertation, TU Delft 2018, section 5.4.1; van Herk 1992, "A fast algorithm for local minimum and
//           maximum filters", down columns; Urbach and Wilkinson 2008, chords, for the disc.
// Differs:  a kernel that reaches over the edge sees nothing there, in both passes: the closing stays idempotent,
//           extensive and monotone, and a hole at the edge is closed as if the map were mirrored. The sloped kernel of
//           eq. 5.3 is flat where values are slopes, so that dilate_row_forward is all of it.
// Bound:    square: 6 comparisons per texel down columns; rows: row_extremes_kernel.hpp. Disc: 2 per row of the
//           kernel and pass, and a copy of the map. No NaN. All values are exact: every SIMD target gives the same.
#pragma once
#include "core/progress.hpp"
#include "scene/occluder_edit.hpp"
#include <cstddef>
#include <cstdint>
#include <span>

namespace tyndall::light_shafts::flat_filters {
/// A picture somewhere else: texel (x, y) is values[y * stride + x].
struct MapSpan {
    float* values = nullptr;
    std::int32_t width = 0, height = 0;
    std::ptrdiff_t stride = 0; ///< In floats, at least the width.
};

/// Closes, in place, the holes that the kernel does not fit into: all texels no farther away than the radius (disc), or
/// 2 round(radius) + 1 texels upright (square). Below half a texel nothing happens. Throws InvalidInput for a radius that
/// is not a number or negative, and Cancelled, after which the map holds anything.
void close_map(MapSpan map, KernelShape shape, float radius_texels, const Progress& progress);

/// Closes, in place, what is shorter than `length` samples. Even lengths stand half way between two samples, so that a
/// row that is turned around is closed the same way; below 2 nothing happens.
void close_row(std::span<float> row, std::int32_t length);

/// row[i] becomes the largest of row[i - reach] to row[i]: things grow towards higher numbers. Nothing below 1.
void dilate_row_forward(std::span<float> row, std::int32_t reach);
} // namespace tyndall::light_shafts::flat_filters
