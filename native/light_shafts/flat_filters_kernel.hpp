// SPDX-License-Identifier: GPL-3.0-or-later
// The vector loops of flat filters, dispatched at run time to the best SIMD target of the machine.
#pragma once
#include "light_shafts/flat_filters.hpp"
#include <vector>

namespace tyndall::light_shafts::flat_filters {
inline constexpr std::size_t row_slack = 64; ///< Floats behind a row that vectors may reach.

/// Line i becomes the largest (dilation) or smallest of the `width` lines from i on, in place and for each i below `count`:
/// lines are `strip_width` floats wide, and there are count + width - 1 of them.
inline constexpr std::size_t strip_width = 64;
void running_extreme_down(bool is_dilation, float* rows, std::size_t count, std::size_t width);

/// A disc as rows: the texels of row dy reach half_widths[of_row[|dy|]] to either side.
struct Disc {
    std::size_t radius = 0;               ///< Rows above and below the middle one.
    std::vector<std::size_t> half_widths; ///< Distinct, falling.
    std::vector<std::size_t> of_row;      ///< Rising: radius + 1 indices into half_widths.
};
/// Running extremes of widths 1, 2, 4, .. of one row.
struct DoubledRow {
    std::size_t stride = 0; ///< Floats from a width to its double.
    std::vector<float> values;
};
/// Largest (dilation) or smallest values of one row's texels under every chord of the disc go to the rows above and below:
/// `outputs[radius + dy]` is disc_tile_width floats wide and belongs to the row dy below this one. The first width of
/// `row` holds the tile's texels, with half_widths[0] on either side.
inline constexpr std::size_t disc_tile_width = 128;
void spread_row(bool is_dilation, const Disc& disc, DoubledRow& row, float* const* outputs);
} // namespace tyndall::light_shafts::flat_filters
