// SPDX-License-Identifier: GPL-3.0-or-later
// Every k-th line of every k-th slope row: shadows as fine as weights along a ray need them, where radiance needs more.
// Bound:    reads the kept rows once, all their cache lines where k <= 16; 4.5 bytes per sample kept. Built once, when first
//           asked for.
#pragma once
#include "light_shafts/slope_rows.hpp"

namespace tyndall::light_shafts {
struct CoarseRows {
    std::int32_t stride = 1; ///< Lines, and slices, of the rows per one of these; 1: they are the rows themselves.
    slope_rows::Layout
        layout; ///< Of the rows, without tables and extents, but the first line and length of a line here.
    std::int32_t slice_count;     ///< Of the rows; there are so many over stride, rounded up, here.
    const slope_rows::Rows* rows; ///< What this came from, which outlives it.
    struct Extent {
        std::int32_t first = 0, end = 0; ///< Lines, multiples of block_lines.
        std::size_t offset = 0;
    };
    std::vector<Extent> extents;
    std::vector<float> slopes, lowest, highest;

    [[nodiscard]] slope_rows::RowView row(std::int32_t index) const {
        if (stride == 1)
            return rows->row(index);
        const Extent& extent = extents[static_cast<std::size_t>(index)];
        const std::size_t block = extent.offset / slope_rows::block_lines;
        return {slopes.data() + extent.offset, lowest.data() + block, highest.data() + block, extent.first, extent.end};
    }
};

/// With at most `most_lines` lines, which is at least 16. `rows` must outlive the result.
[[nodiscard]] CoarseRows make_coarse_rows(const slope_rows::Rows& rows, std::int32_t most_lines);
} // namespace tyndall::light_shafts
