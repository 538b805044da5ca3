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
#include <cstddef>
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
    std::int32_t slice, first, last;
    float near_index; ///< Of the ray's near end, in lines.
};
enum class Cover : std::int32_t { Rows, NearEpipole, Outside };

/// Of placed rays, in columns.
struct RowHits {
    template <class Value>
    using Column = std::array<Value, PlacedRays::capacity>;
    alignas(64) Column<std::int32_t> slice, first, last, cover;
    alignas(64) Column<float> near_index;
    [[nodiscard]] RowHit hit(std::size_t i) const { return {slice[i], first[i], last[i], near_index[i]}; }
};

/// nearest_slice on vectors.
HWY_INLINE hn::Vec<LineTag> slices_at(const Layout& layout, hn::Vec<LineTag> coordinate) {
    const auto d = lines_tag;
    const auto half = hn::Set(d, 0.5f);
    auto slice = hn::Div(hn::Sub(coordinate, hn::Set(d, layout.first_slice)), hn::Set(d, layout.slice_step));
    if (layout.slices_per_turn > 0) {
        const auto turn = hn::Set(d, static_cast<float>(layout.slices_per_turn));
        slice = hn::IfThenElse(hn::Lt(slice, hn::Neg(half)), hn::Add(slice, turn), slice);
        slice = hn::IfThenElse(hn::Ge(slice, hn::Sub(turn, half)), hn::Sub(slice, turn), slice);
    }
    return hn::Floor(hn::Add(slice, half));
}

HWY_INLINE void find_rows(const Layout& layout, const PlacedRays& placed, std::size_t count, RowHits& hits) {
    static constexpr hn::RebindToSigned<LineTag> whole_tag;
    const auto d = lines_tag;
    const auto di = whole_tag;
    const auto set = [&](float value) { return hn::Set(d, value); };
    const Frame& frame = layout.frame;
    const auto half = set(0.5f);
    static_assert(sizeof(RowExtent) == 24);
    const auto* extents = reinterpret_cast<const std::int32_t*>(layout.rows.data());
    const auto& radius = frame.is_orthographic ? placed.radial : placed.radial_per_m;
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
        const auto slice = slices_at(layout, hn::Load(d, &placed.slice_coordinate[i]));
        const auto has_slice =
            hn::And(hn::Ge(slice, hn::Zero(d)), hn::Lt(slice, set(static_cast<float>(layout.slice_count()))));
        const auto row = hn::ConvertTo(di, hn::IfThenElseZero(has_slice, slice));
        const auto of_row = [&](std::size_t offset) {
            return hn::GatherIndex(di, extents + offset / 4, hn::Mul(row, hn::Set(di, 6)));
        };
        auto from = hn::Zero(d), to = from, smallest = from;
        const std::int32_t first_row = hn::GetLane(row);
        if (hn::AllTrue(di, hn::Eq(row, hn::Set(di, first_row)))) { // as rays in the order of slices mostly are
            const RowExtent& extent = layout.rows[static_cast<std::size_t>(first_row)];
            from = set(static_cast<float>(extent.first));
            to = set(static_cast<float>(extent.end));
            smallest = set(extent.smallest_slope);
        } else {
            from = hn::ConvertTo(d, of_row(offsetof(RowExtent, first)));
            to = hn::ConvertTo(d, of_row(offsetof(RowExtent, end)));
            smallest = hn::BitCast(d, of_row(offsetof(RowExtent, smallest_slope)));
        }
        const auto index_of = [&](const PlacedRays::Column& line) {
            return hn::Mul(hn::Sub(hn::Load(d, &line[i]), set(layout.first_line)), set(1.0f / layout.line_step));
        };
        const auto near = index_of(placed.near_line), far = index_of(placed.far_line);
        auto first = hn::Ceil(hn::Sub(near, half)), last = hn::Floor(hn::Sub(far, half));
        const auto is_short = hn::Gt(first, last); // too short to cross a centre
        const auto middle = hn::Floor(hn::Mul(half, hn::Add(near, far)));
        first = hn::IfThenElse(is_short, middle, first);
        last = hn::Min(hn::IfThenElse(is_short, middle, last), set(static_cast<float>(layout.line_count - 1)));
        first = hn::Min(first, last);
        const auto is_inside = hn::And(
            hn::And(hn::And(hn::Gt(near, set(-2.0f)), hn::Lt(far, set(1e7f))), has_slice),
            hn::And(hn::And(hn::Ge(first, from), hn::Lt(last, to)), hn::Ge(hn::Load(d, &placed.slope[i]), smallest)));
        auto cover = hn::IfThenElse(hn::RebindMask(di, is_inside), hn::Set(di, static_cast<int>(Cover::Rows)),
                                    hn::Set(di, static_cast<int>(Cover::Outside)));
        if (!frame.is_parallel)
            cover = hn::IfThenElse(hn::RebindMask(di, hn::Lt(hn::Load(d, &radius[i]), set(layout.smallest_radius))),
                                   hn::Set(di, static_cast<int>(Cover::NearEpipole)), cover);
        hn::Store(row, di, &hits.slice[i]);
        hn::Store(cover, di, &hits.cover[i]);
        hn::Store(hn::ConvertTo(di, hn::IfThenElseZero(is_inside, first)), di, &hits.first[i]);
        hn::Store(hn::ConvertTo(di, hn::IfThenElseZero(is_inside, last)), di, &hits.last[i]);
        hn::Store(near, d, &hits.near_index[i]);
    }
}
} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
