// SPDX-License-Identifier: GPL-3.0-or-later
// Largest and smallest values of the windows along one row, dispatched at run time to the best SIMD target of the machine.
// Based on: van Herk's question, not his answer: windows of 2, 4, 8, .. values are each the extreme of two halves.
// Differs:  up to a vector's width the halves are shifts of registers, and a vector is stored once; wider windows are
//           extremes of aligned vectors, but one. The erosion takes what the dilation gives while it is in registers.
// Bound:    per vector of a row and pass log2 of its lanes shifts, log4 of the width in vectors sweeps over memory of the
//           size of a row: 12 KiB of scratch for 2,048 values and windows of 61, all of it in the first cache.
#pragma once
#include <cstddef>

namespace tyndall::light_shafts::flat_filters {
/// The values that a window around value i sees: `before` of them, i itself, `after` of them; those that exist.
struct Window {
    std::size_t before = 0, after = 0;
    [[nodiscard]] std::size_t width() const { return before + 1 + after; }
};

/// Floats of scratch memory, aligned as vectors are, that the filters of a row need.
[[nodiscard]] constexpr std::size_t row_scratch_size(std::size_t count, std::size_t width) {
    return 2 * ((count + 2 * width + 15) / 16 * 16 + 160);
}

/// row[i] becomes the largest (dilation) or the smallest value under its window of 2 values or more.
void extremes_along(bool is_dilation, float* row, std::size_t count, const Window& window, float* scratch);

/// row[i] becomes the smallest of the dilated values that see it, where value c, below `centre_count`, is dilated by
/// `window`. With window.before + 1 == window.after, centres lie half way between two values: there is one less.
void close_along(float* row, std::size_t count, const Window& window, std::size_t centre_count, float* scratch);
} // namespace tyndall::light_shafts::flat_filters
