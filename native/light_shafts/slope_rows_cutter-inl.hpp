// SPDX-License-Identifier: GPL-3.0-or-later
// Cuts of triangles by slices, 4 to 16 lanes at a time, for any raster that fills rows from them; compiled once per SIMD
// target: include after hwy/highway.h, inside foreach_target's passes.
// Bound:    about 70 operations per triangle and slice on all lanes, and as many again if it crosses the centre of a line.
#if defined(TYNDALL_SLOPE_ROWS_CUTTER_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TYNDALL_SLOPE_ROWS_CUTTER_INL
#undef TYNDALL_SLOPE_ROWS_CUTTER_INL
#else
#define TYNDALL_SLOPE_ROWS_CUTTER_INL
#endif
#include "light_shafts/slope_rows_frame-inl.hpp"
#include "light_shafts/slope_rows_kernels.hpp"
#include <algorithm>
#include <cstddef>
#include <hwy/highway.h>
#include <type_traits>

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
/// Segments of one vector of cuts, ready to raster.
struct Segments {
    alignas(64) std::array<float, 16> x_factor, constant, lowest, highest;
    alignas(64) std::array<std::int32_t, 16> first, last, slice;
};

/// The same of partial occluders: what tells which point of the triangle lies on a line.
struct PartialSegments : Segments {
    using Column = std::array<float, 16>;
    alignas(64) Column x, x_run, w, w_run; ///< X = x / w at the first end, and what is added up to the other.
    alignas(64) Column a, a_run;
    alignas(64) std::array<Column, 2> weight, weight_run; ///< Of the second and the third corner.
    alignas(64) std::array<std::int32_t, 16> triangle;
};

/// Cuts triangles by slices, a vector at a time. Most cuts of small triangles pass between two centres of lines; those
/// that do not wait until there is a vector of them. A Raster is called with segments, which of them, and its row; one of
/// partial occluders (PlacedPartials, PartialSegments) says so by is_partial.
template <class Raster>
class Cutter {
    static constexpr bool is_partial = Raster::is_partial;
    using Placed = typename Raster::Placed;

public:
    Cutter(const Layout& layout, const Placed& triangles, Raster raster)
        : layout_(layout), triangles_(triangles), raster_(raster) {}

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
        V weight[2][3]; ///< Partial: of the second and the third corner, at each corner.
        hn::Vec<decltype(di)> index;
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
    /// The same of partial occluders: weights of the second and the third corner at both ends, and which triangle.
    struct WaitingPartial : Waiting {
        alignas(64) std::array<typename Waiting::template Column<float>, 4> weight;
        alignas(64) typename Waiting::template Column<std::int32_t> triangle;
    };

    void add_many(std::size_t triangle, std::int32_t first, std::int32_t last);
    void cut_gathered();
    HWY_INLINE void cut(const Triangles& triangles, const Slices& slices, std::size_t count);
    void raster_waiting(std::size_t count);

    const Layout& layout_;
    const Placed& triangles_;
    Raster raster_;
    std::size_t count_ = 0;
    alignas(64) std::array<std::int32_t, 16> triangle_, slice_;
    std::conditional_t<is_partial, WaitingPartial, Waiting> waiting_;
    std::conditional_t<is_partial, PartialSegments, Segments> segments_;
};

/// Slices of one triangle side by side: no lane gathers anything.
template <class Raster>
void Cutter<Raster>::add_many(std::size_t triangle, std::int32_t first, std::int32_t last) {
    Triangles same;
    for (std::size_t c = 0; c < 3; ++c) {
        same.a[c] = set(triangles_.axy[3 * c][triangle]);
        same.x[c] = set(triangles_.axy[3 * c + 1][triangle]);
        same.y[c] = set(triangles_.axy[3 * c + 2][triangle]);
    }
    if constexpr (is_partial) {
        same.index = hn::Set(di, static_cast<std::int32_t>(triangle));
        for (std::size_t c = 0; c < 3; ++c)
            for (std::size_t k = 0; k < 2; ++k)
                same.weight[k][c] = set(triangles_.has_weights ? triangles_.weight[3 * k + c][triangle]
                                        : c == k + 1           ? 1.0f
                                                               : 0.0f);
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

template <class Raster>
void Cutter<Raster>::cut_gathered() {
    for (std::size_t i = count_; i < hn::Lanes(d); ++i)
        triangle_[i] = slice_[i] = 0;
    const auto at = hn::Load(di, triangle_.data());
    Triangles gathered;
    for (std::size_t c = 0; c < 3; ++c) {
        gathered.a[c] = hn::GatherIndex(d, triangles_.axy[3 * c].data(), at);
        gathered.x[c] = hn::GatherIndex(d, triangles_.axy[3 * c + 1].data(), at);
        gathered.y[c] = hn::GatherIndex(d, triangles_.axy[3 * c + 2].data(), at);
    }
    if constexpr (is_partial) {
        gathered.index = at;
        for (std::size_t c = 0; c < 3; ++c)
            for (std::size_t k = 0; k < 2; ++k)
                gathered.weight[k][c] = triangles_.has_weights
                                            ? hn::GatherIndex(d, triangles_.weight[3 * k + c].data(), at)
                                            : set(c == k + 1 ? 1.0f : 0.0f);
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

template <class Raster>
void Cutter<Raster>::cut(const Triangles& triangles, const Slices& slices, std::size_t count) {
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
    [[maybe_unused]] V weight1[2], weight2[2];
    if constexpr (is_partial)
        for (std::size_t k = 0; k < 2; ++k) {
            const V* at = triangles.weight[k];
            const V w0 = alone(at);
            weight1[k] = hn::MulAdd(to_other, hn::Sub(other(at), w0), w0);
            weight2[k] = hn::MulAdd(to_third, hn::Sub(third(at), w0), w0);
        }
    if (!frame.is_parallel) { // a half-plane ends at its axis
        const V limit = set(layout_.smallest_radius_cut);
        const Mask below1 = hn::Lt(r1, limit), below2 = hn::Lt(r2, limit);
        is_cut = hn::AndNot(hn::And(below1, below2), is_cut);
        if (!hn::AllFalse(d, hn::Or(below1, below2))) {
            const V share = hn::Div(hn::Sub(limit, r1), hn::Sub(r2, r1));
            const V a_limit = hn::MulAdd(share, hn::Sub(a2, a1), a1);
            if constexpr (is_partial)
                for (std::size_t k = 0; k < 2; ++k) {
                    const V w_limit = hn::MulAdd(share, hn::Sub(weight2[k], weight1[k]), weight1[k]);
                    weight1[k] = hn::IfThenElse(below1, w_limit, weight1[k]);
                    weight2[k] = hn::IfThenElse(below2, w_limit, weight2[k]);
                }
            a1 = hn::IfThenElse(below1, a_limit, a1);
            r1 = hn::IfThenElse(below1, limit, r1);
            a2 = hn::IfThenElse(below2, a_limit, a2);
            r2 = hn::IfThenElse(below2, limit, r2);
        }
    }
    const V per_step = set(1.0f / layout_.line_step), first_line = set(layout_.first_line);
    const V i1 = hn::Mul(hn::Sub(line_at(frame, a1, r1), first_line), per_step),
            i2 = hn::Mul(hn::Sub(line_at(frame, a2, r2), first_line), per_step);
    const V first = hn::Max(hn::Ceil(hn::Sub(hn::Min(i1, i2), set(0.5f + triangles_.overlap))), hn::Zero(d));
    const V last = hn::Min(hn::Floor(hn::Sub(hn::Max(i1, i2), set(0.5f - triangles_.overlap))),
                           set(static_cast<float>(layout_.line_count)));
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
    if constexpr (is_partial) {
        for (std::size_t k = 0; k < 2; ++k) {
            hn::StoreU(hn::Compress(weight1[k], is_cut), d, &waiting_.weight[k][to]);
            hn::StoreU(hn::Compress(weight2[k], is_cut), d, &waiting_.weight[2 + k][to]);
        }
        hn::StoreU(hn::Compress(triangles.index, hn::RebindMask(di, is_cut)), di, &waiting_.triangle[to]);
    }
    waiting_.count += hn::CountTrue(d, is_cut);
    if (waiting_.count >= hn::Lanes(d))
        raster_waiting(hn::Lanes(d));
}

/// The first `count` of those that wait, at most a vector.
template <class Raster>
void Cutter<Raster>::raster_waiting(std::size_t count) {
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
    if constexpr (is_partial) {
        hn::Store(x1, d, segments_.x.data());
        hn::Store(hn::Sub(x2, x1), d, segments_.x_run.data());
        hn::Store(w1, d, segments_.w.data());
        hn::Store(hn::Sub(w2, w1), d, segments_.w_run.data());
        hn::Store(a1, d, segments_.a.data());
        hn::Store(hn::Sub(a2, a1), d, segments_.a_run.data());
        for (std::size_t k = 0; k < 2; ++k) {
            const V from = hn::Load(d, waiting_.weight[k].data()), to = hn::Load(d, waiting_.weight[2 + k].data());
            hn::Store(from, d, segments_.weight[k].data());
            hn::Store(hn::Sub(to, from), d, segments_.weight_run[k].data());
        }
        hn::Store(hn::Load(di, waiting_.triangle.data()), di, segments_.triangle.data());
    }
    const Mask matters = hn::And(hn::And(hn::Gt(highest, smallest), hn::RebindMask(d, hn::Not(hn::Gt(first, last)))),
                                 hn::FirstN(d, count));
    alignas(8) std::array<std::uint8_t, 8> bits{};
    hn::StoreMaskBits(d, matters, bits.data());
    for (std::uint32_t left = bits[0] | static_cast<std::uint32_t>(bits[1]) << 8; left != 0; left &= left - 1) {
        const auto s = static_cast<std::size_t>(__builtin_ctz(left));
        raster_(segments_, s, layout_.rows[static_cast<std::size_t>(segments_.slice[s])]);
    }
    waiting_.count -= count;
    const auto move_down = [&](auto tag, auto& column) {
        hn::Store(hn::LoadU(tag, &column[count]), tag, column.data());
    };
    for (auto* column : {&waiting_.a1, &waiting_.r1, &waiting_.a2, &waiting_.r2, &waiting_.first, &waiting_.last})
        move_down(d, *column);
    move_down(di, waiting_.slice);
    if constexpr (is_partial) {
        for (auto& column : waiting_.weight)
            move_down(d, column);
        move_down(di, waiting_.triangle);
    }
}

/// Gives all placed triangles to the cutter, as far as they touch the slices [first_slice, end_slice); empties `placed`.
template <class Raster>
void cut_all(const Layout& layout, std::int32_t first_slice, std::int32_t end_slice, typename Raster::Placed& placed,
             Raster raster) {
    Cutter<Raster> cutter(layout, placed, raster);
    const std::int32_t turn = layout.slices_per_turn;
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
} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
