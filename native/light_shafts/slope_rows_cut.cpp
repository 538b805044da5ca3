// SPDX-License-Identifier: GPL-3.0-or-later
// Cut, raster and summary of slope rows, 4 to 16 lanes at a time.
// Bound:    a cut is about 70 operations per triangle and slice on all lanes, and as many again if it crosses the
//           centre of a line; a raster writes 16 lines per 6 operations.
#include "light_shafts/slope_rows_kernels.hpp"
#include <algorithm>
#include <cstddef>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "light_shafts/slope_rows_cut.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "light_shafts/slope_rows_frame-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {

/// Segments of one vector of cuts, ready to raster.
struct Segments {
    alignas(64) std::array<float, 16> x_factor, constant, lowest, highest;
    alignas(64) std::array<std::int32_t, 16> first, last, slice;
};

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
        const V x = hn::Load(d, x_at_centre + i);
        // Rounding must not lift a segment above its ends: one along the light would shade its whole line.
        const V slope = hn::Min(hn::Max(hn::MulAdd(factor, x, constant), lowest), highest);
        const auto line = hn::Add(hn::Iota(di, 0), hn::Set(di, i));
        const auto is_inside = hn::And(hn::Gt(line, hn::Set(di, first - 1)), hn::Lt(line, hn::Set(di, last + 1)));
        float* samples = row + (i - extent.first);
        const V before = hn::Load(d, samples);
        hn::Store(hn::IfThenElse(hn::RebindMask(d, is_inside), hn::Max(before, slope), before), d, samples);
    }
}

/// Cuts triangles by slices, a vector at a time. Most cuts of small triangles pass between two centres of lines; those
/// that do not wait until there is a vector of them.
class Cutter {
public:
    Cutter(Rows& rows, const PlacedTriangles& triangles) : rows_(rows), layout_(rows.layout), triangles_(triangles) {}

    void add(std::size_t triangle, std::int32_t first, std::int32_t last) {
        constexpr std::int32_t many = 4; // from here on, idle lanes cost less than gathers
        if (last - first >= many) {
            add_many(triangle, first, last);
            return;
        }
        for (std::int32_t slice = first; slice <= last; ++slice) {
            triangle_[count_] = static_cast<std::int32_t>(triangle);
            slice_[count_++] = slice;
            if (count_ == hn::Lanes(d))
                cut_gathered();
        }
    }
    void finish() {
        if (count_ > 0)
            cut_gathered();
        if (waiting_.count > 0)
            raster_waiting(waiting_.count);
    }

private:
    struct Triangles { // one per lane
        V a[3], x[3], y[3];
    };
    struct Slices {
        hn::Vec<decltype(di)> index;
        V cosine, sine;
    };
    /// Cuts, (a, r) of both ends, that cross the centre of a line.
    struct Waiting {
        template <class Value>
        using Column = std::array<Value, 48>; // a vector more than wait, and a vector is stored whole
        alignas(64) Column<float> a1, r1, a2, r2, first, last;
        alignas(64) Column<std::int32_t> slice;
        std::size_t count = 0;
    };

    void add_many(std::size_t triangle, std::int32_t first, std::int32_t last);
    void cut_gathered();
    HWY_INLINE void cut(const Triangles& triangles, const Slices& slices, std::size_t count);
    void raster_waiting(std::size_t count);

    Rows& rows_;
    const Layout& layout_;
    const PlacedTriangles& triangles_;
    std::size_t count_ = 0;
    alignas(64) std::array<std::int32_t, 16> triangle_, slice_;
    Waiting waiting_;
    Segments segments_;
};

/// Slices of one triangle side by side: no lane gathers anything.
void Cutter::add_many(std::size_t triangle, std::int32_t first, std::int32_t last) {
    Triangles same;
    for (std::size_t c = 0; c < 3; ++c) {
        same.a[c] = set(triangles_.axy[3 * c][triangle]);
        same.x[c] = set(triangles_.axy[3 * c + 1][triangle]);
        same.y[c] = set(triangles_.axy[3 * c + 2][triangle]);
    }
    const auto lanes = static_cast<std::int32_t>(hn::Lanes(d));
    for (std::int32_t slice = first; slice <= last; slice += lanes) {
        Slices slices{hn::Add(hn::Iota(di, 0), hn::Set(di, slice)), set(1.0f), hn::Zero(d)};
        if (!layout_.frame.is_parallel)
            hn::LoadInterleaved2(d, &layout_.slice_directions[static_cast<std::size_t>(slice)].x, slices.cosine,
                                 slices.sine);
        cut(same, slices, static_cast<std::size_t>(std::min(lanes, last - slice + 1)));
    }
}

void Cutter::cut_gathered() {
    for (std::size_t i = count_; i < hn::Lanes(d); ++i)
        triangle_[i] = slice_[i] = 0;
    const auto at = hn::Load(di, triangle_.data());
    Triangles gathered;
    for (std::size_t c = 0; c < 3; ++c) {
        gathered.a[c] = hn::GatherIndex(d, triangles_.axy[3 * c].data(), at);
        gathered.x[c] = hn::GatherIndex(d, triangles_.axy[3 * c + 1].data(), at);
        gathered.y[c] = hn::GatherIndex(d, triangles_.axy[3 * c + 2].data(), at);
    }
    Slices slices{hn::Load(di, slice_.data()), set(1.0f), hn::Zero(d)};
    if (!layout_.frame.is_parallel) {
        const auto* directions = reinterpret_cast<const float*>(layout_.slice_directions.data());
        const auto pair = hn::Add(slices.index, slices.index);
        slices.cosine = hn::GatherIndex(d, directions, pair);
        slices.sine = hn::GatherIndex(d, directions + 1, pair);
    }
    cut(gathered, slices, count_);
    count_ = 0;
}

/// 1 / x, 2e-7 relative.
static HWY_INLINE V reciprocal(V x) {
    const V y = hn::ApproximateReciprocal(x);
    return hn::Mul(y, hn::NegMulAdd(x, y, set(2.0f)));
}

void Cutter::cut(const Triangles& triangles, const Slices& slices, std::size_t count) {
    const Frame& frame = layout_.frame;
    const V* a = triangles.a;
    V r[3], side[3];
    if (frame.is_parallel) {
        const V offset = hn::MulAdd(hn::ConvertTo(d, slices.index), set(layout_.slice_step), set(layout_.first_slice));
        for (int c = 0; c < 3; ++c) {
            r[c] = triangles.x[c];
            side[c] = hn::Sub(triangles.y[c], offset);
        }
    } else {
        for (int c = 0; c < 3; ++c) {
            r[c] = hn::MulAdd(triangles.x[c], slices.cosine, hn::Mul(triangles.y[c], slices.sine));
            side[c] = hn::MulSub(triangles.y[c], slices.cosine, hn::Mul(triangles.x[c], slices.sine));
        }
    }
    const Mask front0 = hn::Ge(side[0], hn::Zero(d)), front1 = hn::Ge(side[1], hn::Zero(d)),
               front2 = hn::Ge(side[2], hn::Zero(d));
    const Mask differ01 = hn::Xor(front0, front1), differ02 = hn::Xor(front0, front2);
    Mask is_cut = hn::And(hn::Or(differ01, differ02), hn::FirstN(d, count));
    // The corner that is alone on its side: 0 if it differs from both, else 1 or 2.
    const Mask alone0 = hn::And(differ01, differ02), alone1 = hn::AndNot(differ02, differ01);
    const auto alone = [&](const V* v) { return hn::IfThenElse(alone0, v[0], hn::IfThenElse(alone1, v[1], v[2])); };
    const auto other = [&](const V* v) { return hn::IfThenElse(alone0, v[1], v[0]); };
    const auto third = [&](const V* v) { return hn::IfThenElse(hn::Or(alone0, alone1), v[2], v[1]); };
    const V a0 = alone(a), r0 = alone(r), s0 = alone(side);
    const V to_other = hn::Mul(s0, reciprocal(hn::Sub(s0, other(side)))),
            to_third = hn::Mul(s0, reciprocal(hn::Sub(s0, third(side))));
    V a1 = hn::MulAdd(to_other, hn::Sub(other(a), a0), a0), r1 = hn::MulAdd(to_other, hn::Sub(other(r), r0), r0);
    V a2 = hn::MulAdd(to_third, hn::Sub(third(a), a0), a0), r2 = hn::MulAdd(to_third, hn::Sub(third(r), r0), r0);
    if (!frame.is_parallel) { // a half-plane ends at its axis
        const V limit = set(layout_.smallest_radius_cut);
        const Mask below1 = hn::Lt(r1, limit), below2 = hn::Lt(r2, limit);
        is_cut = hn::AndNot(hn::And(below1, below2), is_cut);
        if (!hn::AllFalse(d, hn::Or(below1, below2))) {
            const V a_limit = hn::MulAdd(hn::Div(hn::Sub(limit, r1), hn::Sub(r2, r1)), hn::Sub(a2, a1), a1);
            a1 = hn::IfThenElse(below1, a_limit, a1);
            r1 = hn::IfThenElse(below1, limit, r1);
            a2 = hn::IfThenElse(below2, a_limit, a2);
            r2 = hn::IfThenElse(below2, limit, r2);
        }
    }
    const V per_step = set(1.0f / layout_.line_step), first_line = set(layout_.first_line);
    const V i1 = hn::Mul(hn::Sub(line_at(frame, a1, r1), first_line), per_step),
            i2 = hn::Mul(hn::Sub(line_at(frame, a2, r2), first_line), per_step);
    // A thousandth of a line of overlap: neighbours compute their shared end from different corners.
    const V first = hn::Max(hn::Ceil(hn::Sub(hn::Min(i1, i2), set(0.501f))), hn::Zero(d));
    const V last =
        hn::Min(hn::Floor(hn::Sub(hn::Max(i1, i2), set(0.499f))), set(static_cast<float>(layout_.line_count)));
    is_cut = hn::And(is_cut, hn::Le(first, last));
    if (hn::AllFalse(d, is_cut))
        return;
    const std::size_t to = waiting_.count;
    hn::StoreU(hn::Compress(a1, is_cut), d, &waiting_.a1[to]);
    hn::StoreU(hn::Compress(r1, is_cut), d, &waiting_.r1[to]);
    hn::StoreU(hn::Compress(a2, is_cut), d, &waiting_.a2[to]);
    hn::StoreU(hn::Compress(r2, is_cut), d, &waiting_.r2[to]);
    hn::StoreU(hn::Compress(first, is_cut), d, &waiting_.first[to]);
    hn::StoreU(hn::Compress(last, is_cut), d, &waiting_.last[to]);
    hn::StoreU(hn::Compress(slices.index, hn::RebindMask(di, is_cut)), di, &waiting_.slice[to]);
    waiting_.count += hn::CountTrue(d, is_cut);
    if (waiting_.count >= hn::Lanes(d))
        raster_waiting(hn::Lanes(d));
}

/// The first `count` of those that wait, at most a vector.
void Cutter::raster_waiting(std::size_t count) {
    const Frame& frame = layout_.frame;
    const V a1 = hn::Load(d, waiting_.a1.data()), r1 = hn::Load(d, waiting_.r1.data());
    const V a2 = hn::Load(d, waiting_.a2.data()), r2 = hn::Load(d, waiting_.r2.data());
    const V x1 = linear_at(frame.x, a1, r1), y1 = linear_at(frame.y, a1, r1), w1 = linear_at(frame.w, a1, r1);
    const V x2 = linear_at(frame.x, a2, r2), y2 = linear_at(frame.y, a2, r2), w2 = linear_at(frame.w, a2, r2);
    const V slope1 = hn::Div(y1, w1), slope2 = hn::Div(y2, w2);
    const V highest = hn::Max(slope1, slope2);
    // The line through both ends in homogeneous coordinates: no division by a small r.
    const V run = hn::MulSub(w1, x2, hn::Mul(x1, w2));
    const Mask is_along_light = hn::Eq(run, hn::Zero(d));
    const V per_run = hn::Div(set(1.0f), hn::IfThenElse(is_along_light, set(1.0f), run));
    const V factor = hn::Mul(hn::MulSub(w1, y2, hn::Mul(y1, w2)), per_run);
    const V constant = hn::Mul(hn::MulSub(y1, x2, hn::Mul(x1, y2)), per_run);
    hn::Store(hn::IfThenElse(is_along_light, hn::Zero(d), factor), d, segments_.x_factor.data());
    hn::Store(hn::IfThenElse(is_along_light, highest, constant), d, segments_.constant.data());
    hn::Store(hn::Min(slope1, slope2), d, segments_.lowest.data());
    hn::Store(highest, d, segments_.highest.data());
    const auto slice =
        hn::IfThenElseZero(hn::RebindMask(di, hn::FirstN(d, count)), hn::Load(di, waiting_.slice.data()));
    static_assert(sizeof(RowExtent) == 24);
    const auto row = hn::Mul(slice, hn::Set(di, 6));
    const auto* extents = reinterpret_cast<const std::int32_t*>(layout_.rows.data());
    const auto first = hn::Max(hn::ConvertTo(di, hn::Load(d, waiting_.first.data())),
                               hn::GatherIndex(di, extents + offsetof(RowExtent, first) / 4, row));
    const auto last =
        hn::Min(hn::ConvertTo(di, hn::Load(d, waiting_.last.data())),
                hn::Sub(hn::GatherIndex(di, extents + offsetof(RowExtent, end) / 4, row), hn::Set(di, 1)));
    const V smallest =
        hn::GatherIndex(d, reinterpret_cast<const float*>(extents) + offsetof(RowExtent, smallest_slope) / 4, row);
    hn::Store(first, di, segments_.first.data());
    hn::Store(last, di, segments_.last.data());
    hn::Store(slice, di, segments_.slice.data());
    const Mask matters = hn::And(hn::And(hn::Gt(highest, smallest), hn::RebindMask(d, hn::Not(hn::Gt(first, last)))),
                                 hn::FirstN(d, count));
    alignas(8) std::array<std::uint8_t, 8> bits{};
    hn::StoreMaskBits(d, matters, bits.data());
    for (std::uint32_t left = bits[0] | static_cast<std::uint32_t>(bits[1]) << 8; left != 0; left &= left - 1) {
        const auto s = static_cast<std::size_t>(__builtin_ctz(left));
        const RowExtent& extent = layout_.rows[static_cast<std::size_t>(segments_.slice[s])];
        if (!raster_few(rows_, segments_, s, extent))
            raster_segment(rows_, segments_, s, extent);
    }
    waiting_.count -= count;
    const auto move_down = [&](auto tag, auto& column) {
        hn::Store(hn::LoadU(tag, &column[count]), tag, column.data());
    };
    for (auto* column : {&waiting_.a1, &waiting_.r1, &waiting_.a2, &waiting_.r2, &waiting_.first, &waiting_.last})
        move_down(d, *column);
    move_down(di, waiting_.slice);
}

void raster_triangles_of(Rows& rows, std::int32_t first_slice, std::int32_t end_slice, PlacedTriangles& placed) {
    Cutter cutter(rows, placed);
    const std::int32_t turn = rows.layout.slices_per_turn;
    for (std::size_t t = 0; t < placed.count; ++t) {
        const auto first = static_cast<std::int32_t>(std::clamp(placed.first_slice[t], -1.0f, 1e8f));
        const auto last = static_cast<std::int32_t>(std::clamp(placed.last_slice[t], -1.0f, 1e8f));
        cutter.add(t, std::max(first, first_slice), std::min(last, end_slice - 1));
        if (turn > 0 && last >= turn)
            cutter.add(t, std::max(first - turn, first_slice), std::min({last - turn, first - 1, end_slice - 1}));
    }
    cutter.finish();
    placed.count = 0;
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
