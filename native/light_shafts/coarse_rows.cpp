// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/coarse_rows.hpp"
#include "core/parallel.hpp"
#include <algorithm>

namespace tyndall::light_shafts {
using slope_rows::block_lines;

static void fill(const slope_rows::RowView& from, std::int32_t stride, const CoarseRows::Extent& extent,
                 CoarseRows& coarse) {
    for (std::int32_t block = extent.first; block < extent.end; block += block_lines) {
        const std::size_t at = extent.offset + static_cast<std::size_t>(block - extent.first);
        float lowest = std::numeric_limits<float>::infinity(), highest = -lowest;
        for (std::int32_t i = 0; i < block_lines; ++i) {
            // What no ray crosses repeats its neighbour: a block stays as dark or as lit as it is.
            const std::int32_t line = std::clamp((block + i) * stride + stride / 2, from.first, from.end - 1);
            const float slope = from.slopes[line - from.first];
            coarse.slopes[at + static_cast<std::size_t>(i)] = slope;
            lowest = std::min(lowest, slope);
            highest = std::max(highest, slope);
        }
        coarse.lowest[at / block_lines] = lowest;
        coarse.highest[at / block_lines] = highest;
    }
}

CoarseRows make_coarse_rows(const slope_rows::Rows& rows, std::int32_t most_lines) {
    const slope_rows::Layout& layout = rows.layout;
    CoarseRows coarse{.stride = std::max(1, (layout.line_count + most_lines - 1) / most_lines),
                      .layout = {},
                      .slice_count = layout.slice_count(),
                      .rows = &rows,
                      .extents = {},
                      .slopes = {},
                      .lowest = {},
                      .highest = {}};
    const std::int32_t stride = coarse.stride;
    coarse.layout.frame = layout.frame;
    coarse.layout.first_slice = layout.first_slice;
    coarse.layout.slice_step = layout.slice_step;
    coarse.layout.slices_per_turn = layout.slices_per_turn;
    coarse.layout.first_line = layout.first_line;
    coarse.layout.line_step = layout.line_step * static_cast<float>(stride);
    coarse.layout.smallest_radius = layout.smallest_radius;
    if (stride == 1)
        return coarse;
    std::size_t sample_count = 0;
    const auto source = [&](std::size_t row) {
        return std::min(static_cast<std::int32_t>(row) * stride + stride / 2, coarse.slice_count - 1);
    };
    coarse.extents.resize(static_cast<std::size_t>((coarse.slice_count + stride - 1) / stride));
    for (std::size_t row = 0; row < coarse.extents.size(); ++row) {
        const auto& from = layout.rows[static_cast<std::size_t>(source(row))];
        if (from.first >= from.end)
            continue;
        const std::int32_t per_block = stride * block_lines;
        coarse.extents[row] = {.first = from.first / per_block * block_lines,
                               .end = (from.end + per_block - 1) / per_block * block_lines,
                               .offset = sample_count};
        sample_count += static_cast<std::size_t>(coarse.extents[row].end - coarse.extents[row].first);
    }
    coarse.slopes.resize(sample_count + block_lines);
    coarse.lowest.resize(sample_count / block_lines + block_lines); // queries read whole vectors of blocks
    coarse.highest.resize(coarse.lowest.size());
    parallel_for(
        coarse.extents.size(), Progress(),
        [&](std::size_t row) {
            if (coarse.extents[row].first < coarse.extents[row].end)
                fill(rows.row(source(row)), stride, coarse.extents[row], coarse);
        },
        16);
    return coarse;
}
} // namespace tyndall::light_shafts
