// SPDX-License-Identifier: GPL-3.0-or-later
// What both queries of slope rows share, compiled once per SIMD target: masks of 16 lines, and where a ray meets a row.
#if defined(TYNDALL_ROW_QUERY_LANE_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TYNDALL_ROW_QUERY_LANE_INL
#undef TYNDALL_ROW_QUERY_LANE_INL
#else
#define TYNDALL_ROW_QUERY_LANE_INL
#endif
#include "light_shafts/row_query.hpp"
#include "light_shafts/slope_rows_kernels.hpp"
#include <algorithm>
#include <cmath>
#include <cstring>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace slope_rows;
using LineTag = hn::CappedTag<float, 16>;
static constexpr LineTag lines_tag;

template <class Mask>
HWY_INLINE std::uint32_t bits_of(Mask mask) {
    alignas(8) std::uint8_t bytes[8] = {};
    hn::StoreMaskBits(lines_tag, mask, bytes);
    std::uint32_t bits;
    std::memcpy(&bits, bytes, sizeof(bits));
    return bits & ((1u << hn::Lanes(lines_tag)) - 1);
}

/// Bit i: slope >= values[i], for 16 values. A line without an occluder holds -inf and is lit.
HWY_INLINE std::uint32_t at_or_above(hn::Vec<LineTag> slope, const float* values) {
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < block_lines; i += hn::Lanes(lines_tag))
        bits |= bits_of(hn::Ge(slope, hn::LoadU(lines_tag, values + i))) << i;
    return bits;
}

/// The row that answers a ray, and the lines whose centres the ray crosses. Its ends belong to the nearest of them: a
/// centre behind the surface where the ray ends would find that very surface and call it a shadow.
struct RowHit {
    std::int32_t slice = -1, first = 0, last = -1;
    float near_index, far_index; ///< Of the ray's ends, in lines.
};
enum class Cover : std::uint8_t { Rows, NearEpipole, Outside };

HWY_INLINE Cover find_row(const Layout& layout, const PlacedRays& placed, std::size_t i, RowHit& hit) {
    const Frame& frame = layout.frame;
    if (!frame.is_parallel &&
        (frame.is_orthographic ? placed.radial[i] : placed.radial_per_m[i]) < layout.smallest_radius)
        return Cover::NearEpipole;
    hit.slice = nearest_slice(layout, placed.slice_coordinate[i]);
    if (hit.slice < 0 || hit.slice >= layout.slice_count())
        return Cover::Outside;
    const RowExtent& extent = layout.rows[static_cast<std::size_t>(hit.slice)];
    const float per_step = 1.0f / layout.line_step;
    hit.near_index = (placed.near_line[i] - layout.first_line) * per_step;
    hit.far_index = (placed.far_line[i] - layout.first_line) * per_step;
    if (!(hit.near_index > -2.0f && hit.far_index < 1e7f))
        return Cover::Outside;
    hit.first = static_cast<std::int32_t>(std::ceil(hit.near_index - 0.5f));
    hit.last = static_cast<std::int32_t>(std::floor(hit.far_index - 0.5f));
    if (hit.first > hit.last) // too short to cross a centre
        hit.first = hit.last = static_cast<std::int32_t>(0.5f * (hit.near_index + hit.far_index));
    hit.last = std::min(hit.last, layout.line_count - 1);
    hit.first = std::min(hit.first, hit.last);
    const bool is_inside =
        hit.first >= extent.first && hit.last < extent.end && placed.slope[i] >= extent.smallest_slope;
    return is_inside ? Cover::Rows : Cover::Outside;
}
} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
