// SPDX-License-Identifier: GPL-3.0-or-later
// Cut, raster and summary of slope rows, 4 to 16 lanes at a time.
// Bound:    a cut is about 120 operations per triangle and slice on all lanes; a raster writes 16 lines per 6 operations.
#include "light_shafts/slope_rows_kernels.hpp"
#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "light_shafts/slope_rows_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "light_shafts/slope_rows_angle-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
using namespace slope_rows;
using Tag = hn::CappedTag<float, 16>;
using V = hn::Vec<Tag>;
using Mask = hn::Mask<Tag>;
static constexpr Tag d;
static constexpr hn::RebindToSigned<Tag> di;

static HWY_INLINE V set(float value) { return hn::Set(d, value); }
static HWY_INLINE V linear_at(const Linear& f, V a, V r) {
    return hn::MulAdd(set(f.per_axial), a, hn::MulAdd(set(f.per_radial), r, set(f.at_origin)));
}
static HWY_INLINE V line_at(const Frame& frame, V a, V r) {
    return frame.is_angular ? atan2_of(d, hn::Mul(set(frame.angle_scale), r), linear_at(frame.x, a, r)) : r;
}
static HWY_INLINE V dot(const vec3& axis, V x, V y, V z) {
    return hn::MulAdd(set(axis.x), x, hn::MulAdd(set(axis.y), y, hn::Mul(set(axis.z), z)));
}

void place_rays_of(const Frame& frame, const ViewRay* rays, std::size_t count, PlacedRays& placed) {
    static_assert(sizeof(ViewRay) == 8 * sizeof(float));
    const auto* floats = reinterpret_cast<const float*>(rays);
    const auto stride = hn::Mul(hn::Iota(di, 0), hn::Set(di, 8));
    const auto last = hn::Set(di, static_cast<std::int32_t>(8 * (count - 1)));
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
        const auto at = hn::Min(hn::Add(stride, hn::Set(di, static_cast<std::int32_t>(8 * i))), last);
        const auto field = [&](int index) { return hn::GatherIndex(d, floats + index, at); };
        const V dx = field(3), dy = field(4), dz = field(5), near_m = field(6), far_m = field(7);
        const V du = dot(frame.u, dx, dy, dz), dv = dot(frame.v, dx, dy, dz), da = dot(frame.axis, dx, dy, dz);
        V slice, slope, axial = hn::Zero(d), radial = hn::Zero(d), radial_per_m;
        if (!frame.is_orthographic) {
            slice = atan2_of(d, dv, du);
            radial_per_m = hn::Sqrt(hn::MulAdd(du, du, hn::Mul(dv, dv)));
            slope = hn::Div(da, radial_per_m);
        } else {
            const V px = hn::Sub(field(0), set(frame.origin.x)), py = hn::Sub(field(1), set(frame.origin.y)),
                    pz = hn::Sub(field(2), set(frame.origin.z));
            const V pu = dot(frame.u, px, py, pz), pv = dot(frame.v, px, py, pz);
            axial = dot(frame.axis, px, py, pz);
            if (frame.is_parallel) {
                slice = pv;
                radial = pu;
                radial_per_m = du;
                slope = linear_at(frame.y, axial, radial);
            } else {
                slice = atan2_of(d, pv, pu);
                radial = hn::Sqrt(hn::MulAdd(pu, pu, hn::Mul(pv, pv)));
                radial_per_m = hn::Zero(d);
                slope = hn::Div(set(1.0f), radial);
            }
        }
        const auto end = [&](V t) {
            return line_at(frame, hn::MulAdd(t, da, axial), hn::MulAdd(t, radial_per_m, radial));
        };
        hn::Store(slice, d, &placed.slice_coordinate[i]);
        hn::Store(slope, d, &placed.slope[i]);
        hn::Store(axial, d, &placed.axial[i]);
        hn::Store(radial, d, &placed.radial[i]);
        hn::Store(da, d, &placed.axial_per_m[i]);
        hn::Store(radial_per_m, d, &placed.radial_per_m[i]);
        hn::Store(end(near_m), d, &placed.near_line[i]);
        hn::Store(end(far_m), d, &placed.far_line[i]);
    }
}

/// Turns an angle difference into (-pi, pi].
static HWY_INLINE V wrapped(V angle) {
    constexpr float turn = 2 * std::numbers::pi_v<float>;
    return hn::NegMulAdd(hn::Round(hn::Mul(angle, set(1 / turn))), set(turn), angle);
}

void place_triangles_of(const Layout& layout, const TriangleSource& source, PlacedTriangles& placed) {
    constexpr float turn = 2 * std::numbers::pi_v<float>;
    const Frame& frame = layout.frame;
    const auto* positions = reinterpret_cast<const float*>(source.positions);
    const auto* corners = reinterpret_cast<const std::int32_t*>(source.triangles);
    const auto stride = hn::Mul(hn::Iota(di, 0), hn::Set(di, 3));
    const auto last = hn::Set(di, static_cast<std::int32_t>(3 * (source.count - 1)));
    const mat3& m = source.frame_from_object;
    const V per_step = set(1.0f / layout.slice_step);
    for (std::size_t i = 0; i < source.count; i += hn::Lanes(d)) {
        const auto at = hn::Min(hn::Add(stride, hn::Set(di, static_cast<std::int32_t>(3 * i))), last);
        V x[3], y[3];
        for (int corner = 0; corner < 3; ++corner) {
            const auto vertex = hn::Mul(hn::GatherIndex(di, corners + corner, at), hn::Set(di, 3));
            const V px = hn::GatherIndex(d, positions, vertex), py = hn::GatherIndex(d, positions + 1, vertex),
                    pz = hn::GatherIndex(d, positions + 2, vertex);
            const auto row = [&](int r) {
                return hn::Add(set(source.origin_in_frame[r]), dot(vec3(m[0][r], m[1][r], m[2][r]), px, py, pz));
            };
            x[corner] = row(0);
            y[corner] = row(1);
            const auto c = static_cast<std::size_t>(3 * corner);
            hn::Store(row(2), d, &placed.axy[c][i]);
            hn::Store(x[corner], d, &placed.axy[c + 1][i]);
            hn::Store(y[corner], d, &placed.axy[c + 2][i]);
        }
        V low, high;
        if (frame.is_parallel) {
            low = hn::Sub(hn::Min(y[0], hn::Min(y[1], y[2])), set(layout.first_slice));
            high = hn::Sub(hn::Max(y[0], hn::Max(y[1], y[2])), set(layout.first_slice));
        } else {
            const V angle = atan2_of(d, y[0], x[0]);
            const V to_1 = wrapped(hn::Sub(atan2_of(d, y[1], x[1]), angle));
            const V to_2 = wrapped(hn::Sub(atan2_of(d, y[2], x[2]), angle));
            const V least = hn::Min(hn::Zero(d), hn::Min(to_1, to_2)), most = hn::Max(hn::Zero(d), hn::Max(to_1, to_2));
            // Seen from the axis a triangle spans less than half a turn, unless the axis pierces it.
            const auto is_pierced = hn::Ge(hn::Sub(most, least), set(turn / 2 - 1e-3f));
            const V from_first = hn::Add(hn::Sub(angle, set(layout.first_slice)), least);
            const V turns = hn::Floor(hn::Mul(from_first, set(1 / turn)));
            low = hn::IfThenElse(is_pierced, hn::Zero(d), hn::NegMulAdd(turns, set(turn), from_first));
            high = hn::IfThenElse(is_pierced, set(turn), hn::Add(low, hn::Sub(most, least)));
        }
        // A hundredth of a slice of slack for the rounding of angles; the cut itself decides.
        hn::Store(hn::Ceil(hn::MulSub(low, per_step, set(0.01f))), d, &placed.first_slice[i]);
        hn::Store(hn::Floor(hn::MulAdd(high, per_step, set(0.01f))), d, &placed.last_slice[i]);
    }
}

/// Segments of one vector of cuts, ready to raster.
struct Segments {
    alignas(64) std::array<float, 16> x_factor, constant, lowest, highest;
    alignas(64) std::array<std::int32_t, 16> first, last, slice;
};

static void raster_segment(const Rows& rows, const Segments& segments, std::size_t s) {
    const RowExtent& extent = rows.layout.rows[static_cast<std::size_t>(segments.slice[s])];
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

/// Cuts pairs of (triangle, slice), a vector at a time.
class Cutter {
public:
    explicit Cutter(Rows& rows, const FramedTriangle* triangles)
        : rows_(rows), layout_(rows.layout), triangles_(reinterpret_cast<const float*>(triangles)) {}

    void add(std::size_t triangle, std::int32_t slice) {
        triangle_[count_] = static_cast<std::int32_t>(10 * triangle);
        slice_[count_++] = slice;
        if (count_ == hn::Lanes(d))
            flush();
    }
    void flush() {
        if (count_ == 0)
            return;
        for (std::size_t i = count_; i < hn::Lanes(d); ++i) { // repeated cuts change nothing
            triangle_[i] = triangle_[0];
            slice_[i] = slice_[0];
        }
        cut();
        count_ = 0;
    }

private:
    void cut();

    Rows& rows_;
    const Layout& layout_;
    const float* triangles_;
    std::size_t count_ = 0;
    alignas(64) std::array<std::int32_t, 16> triangle_, slice_;
    Segments segments_;
};

void Cutter::cut() {
    const Frame& frame = layout_.frame;
    const auto at = hn::Load(di, triangle_.data());
    const auto slice = hn::Load(di, slice_.data());
    V a[3], r[3], side[3];
    const auto* directions = reinterpret_cast<const float*>(layout_.slice_directions.data());
    const auto pair = hn::Add(slice, slice);
    const V cosine = hn::GatherIndex(d, directions, pair), sine = hn::GatherIndex(d, directions + 1, pair);
    const V offset = frame.is_parallel
                         ? hn::MulAdd(hn::ConvertTo(d, slice), set(layout_.slice_step), set(layout_.first_slice))
                         : hn::Zero(d);
    for (int c = 0; c < 3; ++c) {
        a[c] = hn::GatherIndex(d, triangles_ + 3 * c, at);
        const V x = hn::GatherIndex(d, triangles_ + 3 * c + 1, at), y = hn::GatherIndex(d, triangles_ + 3 * c + 2, at);
        r[c] = hn::MulAdd(x, cosine, hn::Mul(y, sine));
        side[c] = hn::Sub(hn::MulSub(y, cosine, hn::Mul(x, sine)), offset);
    }
    const Mask front0 = hn::Ge(side[0], hn::Zero(d)), front1 = hn::Ge(side[1], hn::Zero(d)),
               front2 = hn::Ge(side[2], hn::Zero(d));
    const Mask differ01 = hn::Xor(front0, front1), differ02 = hn::Xor(front0, front2);
    Mask is_cut = hn::Or(differ01, differ02);
    // The corner that is alone on its side: 0 if it differs from both, else 1 or 2.
    const Mask alone0 = hn::And(differ01, differ02), alone1 = hn::AndNot(differ02, differ01);
    const auto alone = [&](const V* v) { return hn::IfThenElse(alone0, v[0], hn::IfThenElse(alone1, v[1], v[2])); };
    const auto other = [&](const V* v) { return hn::IfThenElse(alone0, v[1], v[0]); };
    const auto third = [&](const V* v) { return hn::IfThenElse(hn::Or(alone0, alone1), v[2], v[1]); };
    const V a0 = alone(a), r0 = alone(r), s0 = alone(side);
    const V to_other = hn::Div(s0, hn::Sub(s0, other(side))), to_third = hn::Div(s0, hn::Sub(s0, third(side)));
    V a1 = hn::MulAdd(to_other, hn::Sub(other(a), a0), a0), r1 = hn::MulAdd(to_other, hn::Sub(other(r), r0), r0);
    V a2 = hn::MulAdd(to_third, hn::Sub(third(a), a0), a0), r2 = hn::MulAdd(to_third, hn::Sub(third(r), r0), r0);
    if (!frame.is_parallel) { // a half-plane ends at its axis
        const V limit = set(layout_.smallest_radius_cut);
        const Mask below1 = hn::Lt(r1, limit), below2 = hn::Lt(r2, limit);
        is_cut = hn::AndNot(hn::And(below1, below2), is_cut);
        const V a_limit = hn::MulAdd(hn::Div(hn::Sub(limit, r1), hn::Sub(r2, r1)), hn::Sub(a2, a1), a1);
        a1 = hn::IfThenElse(below1, a_limit, a1);
        r1 = hn::IfThenElse(below1, limit, r1);
        a2 = hn::IfThenElse(below2, a_limit, a2);
        r2 = hn::IfThenElse(below2, limit, r2);
    }
    const V x1 = linear_at(frame.x, a1, r1), y1 = linear_at(frame.y, a1, r1), w1 = linear_at(frame.w, a1, r1);
    const V x2 = linear_at(frame.x, a2, r2), y2 = linear_at(frame.y, a2, r2), w2 = linear_at(frame.w, a2, r2);
    const V slope1 = hn::Div(y1, w1), slope2 = hn::Div(y2, w2);
    const V highest = hn::Max(slope1, slope2);
    // The line through both ends in homogeneous coordinates: no division by a small r.
    const V run = hn::MulSub(w1, x2, hn::Mul(x1, w2));
    const Mask is_along_light = hn::Eq(run, hn::Zero(d));
    const V safe_run = hn::IfThenElse(is_along_light, set(1.0f), run);
    const V factor = hn::Div(hn::MulSub(w1, y2, hn::Mul(y1, w2)), safe_run);
    const V constant = hn::Div(hn::MulSub(y1, x2, hn::Mul(x1, y2)), safe_run);
    const V per_step = set(1.0f / layout_.line_step), first_line = set(layout_.first_line);
    const V i1 = hn::Mul(hn::Sub(line_at(frame, a1, r1), first_line), per_step),
            i2 = hn::Mul(hn::Sub(line_at(frame, a2, r2), first_line), per_step);
    // A thousandth of a line of overlap: neighbours compute their shared end from different corners.
    const V limit = set(static_cast<float>(layout_.line_count));
    const V first = hn::Max(hn::Ceil(hn::Sub(hn::Min(i1, i2), set(0.501f))), hn::Zero(d));
    const V last = hn::Min(hn::Floor(hn::Sub(hn::Max(i1, i2), set(0.499f))), limit);
    hn::Store(hn::IfThenElse(is_along_light, hn::Zero(d), factor), d, segments_.x_factor.data());
    hn::Store(hn::IfThenElse(is_along_light, highest, constant), d, segments_.constant.data());
    hn::Store(hn::Min(slope1, slope2), d, segments_.lowest.data());
    hn::Store(highest, d, segments_.highest.data());
    hn::Store(hn::ConvertTo(di, hn::Min(first, limit)), di, segments_.first.data());
    hn::Store(hn::ConvertTo(di, hn::Max(last, set(-1.0f))), di, segments_.last.data());
    is_cut = hn::And(is_cut, hn::Le(first, last));
    alignas(64) std::array<std::uint8_t, 8> bits{};
    hn::StoreMaskBits(d, is_cut, bits.data());
    std::uint32_t left = bits[0] | static_cast<std::uint32_t>(bits[1]) << 8;
    left &= (1u << count_) - 1;
    segments_.slice = slice_;
    for (; left != 0; left &= left - 1) {
        const auto s = static_cast<std::size_t>(__builtin_ctz(left));
        const RowExtent& extent = layout_.rows[static_cast<std::size_t>(slice_[s])];
        segments_.first[s] = std::max(segments_.first[s], extent.first);
        segments_.last[s] = std::min(segments_.last[s], extent.end - 1);
        if (segments_.first[s] <= segments_.last[s] && segments_.highest[s] > extent.smallest_slope)
            raster_segment(rows_, segments_, s);
    }
}

void raster_band_of(Rows& rows, std::int32_t first_slice, const FramedTriangle* triangles, std::size_t count) {
    // Gathers index 32-bit words: 10 words per triangle, at most 2^27 triangles at a time.
    constexpr std::size_t chunk = std::size_t{1} << 27;
    for (std::size_t start = 0; start < count; start += chunk) {
        Cutter cutter(rows, triangles + start);
        for (std::size_t t = 0; t < std::min(chunk, count - start); ++t)
            for (std::int32_t s = triangles[start + t].first_slice; s <= triangles[start + t].last_slice; ++s)
                cutter.add(t, first_slice + s);
        cutter.flush();
    }
}

void clear_band_of(Rows& rows, std::int32_t first_slice) {
    const std::int32_t end = std::min(first_slice + band_slices, rows.layout.slice_count());
    for (std::int32_t s = first_slice; s < end; ++s) {
        const RowExtent& extent = rows.layout.rows[static_cast<std::size_t>(s)];
        std::fill_n(rows.slopes.get() + extent.offset, extent.end - extent.first, no_occluder);
    }
}

void summarise_band_of(Rows& rows, std::int32_t first_slice) {
    const std::int32_t end = std::min(first_slice + band_slices, rows.layout.slice_count());
    for (std::int32_t s = first_slice; s < end; ++s) {
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
HWY_EXPORT(place_rays_of);
HWY_EXPORT(place_triangles_of);
HWY_EXPORT(raster_band_of);
HWY_EXPORT(clear_band_of);
HWY_EXPORT(summarise_band_of);
} // namespace tyndall::light_shafts

namespace tyndall::light_shafts::slope_rows {
void place_rays(const Frame& frame, std::span<const ViewRay> rays, PlacedRays& placed) {
    if (!rays.empty())
        HWY_DYNAMIC_DISPATCH(place_rays_of)(frame, rays.data(), rays.size(), placed);
}
void place_triangles(const Layout& layout, const TriangleSource& source, PlacedTriangles& placed) {
    if (source.count > 0)
        HWY_DYNAMIC_DISPATCH(place_triangles_of)(layout, source, placed);
}
void raster_band(Rows& rows, std::int32_t first_slice, std::span<const FramedTriangle> triangles) {
    HWY_DYNAMIC_DISPATCH(raster_band_of)(rows, first_slice, triangles.data(), triangles.size());
}
void clear_band(Rows& rows, std::int32_t first_slice) { HWY_DYNAMIC_DISPATCH(clear_band_of)(rows, first_slice); }
void summarise_band(Rows& rows, std::int32_t first_slice) {
    HWY_DYNAMIC_DISPATCH(summarise_band_of)(rows, first_slice);
}
} // namespace tyndall::light_shafts::slope_rows
#endif
