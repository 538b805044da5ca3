// SPDX-License-Identifier: GPL-3.0-or-later
// Raster and summary of slope rows, 4 to 16 lanes at a time; slope_rows_cutter-inl.hpp cuts.
// Bound:    16 lines per 6 operations.
#include "light_shafts/slope_rows_kernels.hpp"
#include <algorithm>
#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "light_shafts/slope_rows_cut.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "light_shafts/slope_rows_cutter-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
/// Few lines, whose number the processor cannot guess: one short vector, wherever it begins.
static constexpr hn::CappedTag<float, 4> few;
static HWY_INLINE bool raster_few(const Rows& rows, const Segments& segments, std::size_t s, const RowExtent& extent) {
    const std::int32_t first = segments.first[s], last = segments.last[s];
    constexpr auto lanes = static_cast<std::int32_t>(hn::MaxLanes(few));
    if (last - first >= lanes || first + lanes > extent.end)
        return false;
    float* samples = rows.slopes.get() + extent.offset + (first - extent.first);
    const auto x = hn::LoadU(few, rows.layout.x_at_centre.data() + first), before = hn::LoadU(few, samples);
    const auto slope = hn::MulAdd(hn::Set(few, segments.x_factor[s]), x, hn::Set(few, segments.constant[s]));
    const auto kept = hn::Min(hn::Max(slope, hn::Set(few, segments.lowest[s])), hn::Set(few, segments.highest[s]));
    const auto is_inside = hn::FirstN(few, static_cast<std::size_t>(last - first + 1));
    hn::StoreU(hn::IfThenElse(is_inside, hn::Max(before, kept), before), few, samples);
    return true;
}

static void raster_segment(const Rows& rows, const Segments& segments, std::size_t s, const RowExtent& extent) {
    const std::int32_t first = segments.first[s], last = segments.last[s];
    float* row = rows.slopes.get() + extent.offset;
    const float* x_at_centre = rows.layout.x_at_centre.data();
    const V factor = set(segments.x_factor[s]), constant = set(segments.constant[s]);
    const V lowest = set(segments.lowest[s]), highest = set(segments.highest[s]);
    const auto lanes = static_cast<std::int32_t>(hn::Lanes(d));
    for (std::int32_t i = first & ~(lanes - 1); i <= last; i += lanes) {
        const V x = hn::LoadU(d, x_at_centre + i);
        // Rounding must not lift a segment above its ends: one along the light would shade its whole line.
        const V slope = hn::Min(hn::Max(hn::MulAdd(factor, x, constant), lowest), highest);
        const auto line = hn::Add(hn::Iota(di, 0), hn::Set(di, i));
        const auto is_inside = hn::And(hn::Gt(line, hn::Set(di, first - 1)), hn::Lt(line, hn::Set(di, last + 1)));
        float* samples = row + (i - extent.first);
        const V before = hn::Load(d, samples);
        hn::Store(hn::IfThenElse(hn::RebindMask(d, is_inside), hn::Max(before, slope), before), d, samples);
    }
}

struct OpaqueRaster {
    using Placed = PlacedTriangles;
    static constexpr bool is_partial = false;
    const Rows& rows;
    void operator()(const Segments& segments, std::size_t s, const RowExtent& extent) const {
        if (!raster_few(rows, segments, s, extent))
            raster_segment(rows, segments, s, extent);
    }
};

void raster_triangles_of(Rows& rows, std::int32_t first_slice, std::int32_t end_slice, PlacedTriangles& placed) {
    cut_all(rows.layout, first_slice, end_slice, placed, OpaqueRaster{rows});
}

void clear_slices_of(Rows& rows, std::int32_t first_slice, std::int32_t end_slice) {
    for (std::int32_t s = first_slice; s < end_slice; ++s) {
        const RowExtent& extent = rows.layout.rows[static_cast<std::size_t>(s)];
        std::fill_n(rows.slopes.get() + extent.offset, extent.end - extent.first, no_occluder);
    }
}

void summarise_slices_of(Rows& rows, std::int32_t first_slice, std::int32_t end_slice) {
    for (std::int32_t s = first_slice; s < end_slice; ++s) {
        const RowExtent& extent = rows.layout.rows[static_cast<std::size_t>(s)];
        const float* row = rows.slopes.get() + extent.offset;
        const std::size_t block = extent.offset / block_lines;
        for (std::int32_t b = 0; b < (extent.end - extent.first) / block_lines; ++b) {
            V low = hn::Load(d, row + b * block_lines), high = low;
            for (std::size_t i = hn::Lanes(d); i < block_lines; i += hn::Lanes(d)) {
                const V next = hn::Load(d, row + b * block_lines + i);
                low = hn::Min(low, next);
                high = hn::Max(high, next);
            }
            rows.lowest[block + static_cast<std::size_t>(b)] = hn::GetLane(hn::MinOfLanes(d, low));
            rows.highest[block + static_cast<std::size_t>(b)] = hn::GetLane(hn::MaxOfLanes(d, high));
        }
    }
}
} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::light_shafts {
HWY_EXPORT(raster_triangles_of);
HWY_EXPORT(clear_slices_of);
HWY_EXPORT(summarise_slices_of);
} // namespace tyndall::light_shafts

namespace tyndall::light_shafts::slope_rows {
void raster_triangles(Rows& rows, std::int32_t first_slice, std::int32_t end_slice, PlacedTriangles& placed) {
    if (placed.count > 0)
        HWY_DYNAMIC_DISPATCH(raster_triangles_of)(rows, first_slice, end_slice, placed);
}
void clear_slices(Rows& rows, std::int32_t first_slice, std::int32_t end_slice) {
    HWY_DYNAMIC_DISPATCH(clear_slices_of)(rows, first_slice, end_slice);
}
void summarise_slices(Rows& rows, std::int32_t first_slice, std::int32_t end_slice) {
    HWY_DYNAMIC_DISPATCH(summarise_slices_of)(rows, first_slice, end_slice);
}
} // namespace tyndall::light_shafts::slope_rows
#endif
