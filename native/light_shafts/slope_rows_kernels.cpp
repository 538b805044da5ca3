// SPDX-License-Identifier: GPL-3.0-or-later
// View rays and triangles into the frame's coordinates, 4 to 16 lanes at a time.
// Bound:    about 130 operations per triangle on all lanes; a triangle that touches no sample which matters ends here.
#include "light_shafts/slope_rows_kernels.hpp"
#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "light_shafts/slope_rows_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "light_shafts/slope_rows_frame-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
static HWY_INLINE V dot(const vec3& axis, V x, V y, V z) {
    return hn::MulAdd(set(axis.x), x, hn::MulAdd(set(axis.y), y, hn::Mul(set(axis.z), z)));
}

/// The eight numbers of rays from `i` on, a lane each; past the last ray it is repeated.
static HWY_INLINE void load_rays(const ViewRay* rays, std::size_t i, std::size_t count,
                                 const std::array<V*, 8>& fields) {
    static_assert(sizeof(ViewRay) == 8 * sizeof(float));
    const auto* floats = reinterpret_cast<const float*>(rays);
    if (i + hn::Lanes(d) <= count) { // in fours: the first and the second half of a ray take turns
        V low[4], high[4];
        hn::LoadInterleaved4(d, floats + 8 * i, low[0], low[1], low[2], low[3]);
        hn::LoadInterleaved4(d, floats + 8 * i + 4 * hn::Lanes(d), high[0], high[1], high[2], high[3]);
        for (std::size_t f = 0; f < 4; ++f) {
            *fields[f] = hn::ConcatEven(d, high[f], low[f]);
            *fields[f + 4] = hn::ConcatOdd(d, high[f], low[f]);
        }
        return;
    }
    const auto stride = hn::Mul(hn::Iota(di, 0), hn::Set(di, 8));
    const auto last = hn::Set(di, static_cast<std::int32_t>(8 * (count - 1)));
    const auto at = hn::Min(hn::Add(stride, hn::Set(di, static_cast<std::int32_t>(8 * i))), last);
    for (std::size_t f = 0; f < 8; ++f)
        *fields[f] = hn::GatherIndex(d, floats + f, at);
}

void place_rays_of(const Frame& frame, const ViewRay* rays, std::size_t count, PlacedRays& placed) {
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
        V ox, oy, oz, dx, dy, dz, near_m, far_m;
        load_rays(rays, i, count, {&ox, &oy, &oz, &dx, &dy, &dz, &near_m, &far_m});
        const V du = dot(frame.u, dx, dy, dz), dv = dot(frame.v, dx, dy, dz), da = dot(frame.axis, dx, dy, dz);
        V slice, slope, axial = hn::Zero(d), radial = hn::Zero(d), radial_per_m;
        if (!frame.is_orthographic) {
            slice = atan2_of(d, dv, du);
            radial_per_m = hn::Sqrt(hn::MulAdd(du, du, hn::Mul(dv, dv)));
            slope = hn::Div(da, radial_per_m);
        } else {
            const V px = hn::Sub(ox, set(frame.origin.x)), py = hn::Sub(oy, set(frame.origin.y)),
                    pz = hn::Sub(oz, set(frame.origin.z));
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
        hn::Store(near_m, d, &placed.near_m[i]);
        hn::Store(far_m, d, &placed.far_m[i]);
        hn::Store(end(near_m), d, &placed.near_line[i]);
        hn::Store(end(far_m), d, &placed.far_line[i]);
    }
}

/// Turns an angle difference into (-pi, pi].
static HWY_INLINE V wrapped(V angle) {
    constexpr float turn = 2 * std::numbers::pi_v<float>;
    return hn::NegMulAdd(hn::Round(hn::Mul(angle, set(1 / turn))), set(turn), angle);
}

/// Angles around the axis that a triangle spans: from `low` on, `span` of them.
struct Angles {
    V low, span;
    Mask is_pierced; ///< The axis goes through the triangle, which touches all slices.
};
static HWY_INLINE Angles angles_of(const V* x, const V* y) {
    const V angle = atan2_of(d, y[0], x[0]);
    // The tangent exceeds the angle, by 8 % at most here: a slice too many now and then, for which the cut is empty.
    const auto tangent_to = [&](int c) {
        const V across = hn::MulSub(x[0], y[c], hn::Mul(y[0], x[c])),
                along = hn::MulAdd(x[0], x[c], hn::Mul(y[0], y[c]));
        return hn::Div(across, hn::Max(along, hn::Zero(d)));
    };
    V to_1 = tangent_to(1), to_2 = tangent_to(2);
    const auto is_narrow = hn::And(hn::Lt(hn::Abs(to_1), set(0.5f)), hn::Lt(hn::Abs(to_2), set(0.5f)));
    Mask is_pierced = hn::FirstN(d, 0);
    if (!hn::AllTrue(d, is_narrow)) {
        to_1 = hn::IfThenElse(is_narrow, to_1, wrapped(hn::Sub(atan2_of(d, y[1], x[1]), angle)));
        to_2 = hn::IfThenElse(is_narrow, to_2, wrapped(hn::Sub(atan2_of(d, y[2], x[2]), angle)));
        // Seen from the axis a triangle spans less than half a turn, unless the axis pierces it.
        const V span = hn::Sub(hn::Max(hn::Zero(d), hn::Max(to_1, to_2)), hn::Min(hn::Zero(d), hn::Min(to_1, to_2)));
        is_pierced = hn::Ge(span, set(std::numbers::pi_v<float> - 1e-3f));
    }
    const V least = hn::Min(hn::Zero(d), hn::Min(to_1, to_2)), most = hn::Max(hn::Zero(d), hn::Max(to_1, to_2));
    return {hn::Add(angle, least), hn::Sub(most, least), is_pierced};
}

void place_triangles_of(const Layout& layout, const SliceNeeds& needs, const TriangleSource& source,
                        PlacedTriangles& placed, std::int32_t* kept) {
    constexpr float turn = 2 * std::numbers::pi_v<float>;
    const Frame& frame = layout.frame;
    const mat3& m = source.frame_from_object;
    const V per_step = set(1.0f / layout.slice_step), per_line = set(1.0f / layout.line_step);
    const V first_needed = set(static_cast<float>(needs.first)), last_needed = set(static_cast<float>(needs.end - 1));
    const V one_turn = set(static_cast<float>(layout.slices_per_turn));
    // Of the angle's cotangent, which falls as the line's number rises.
    const V least_x = set(needs.last_line < 3.14f ? frame.x_of_line(needs.last_line) : no_occluder),
            most_x = set(frame.x_of_line(std::max(needs.first_line, 0.0f)));
    for (std::size_t i = 0; i < source.count; i += hn::Lanes(d)) {
        V a[3], x[3], y[3];
        for (std::size_t corner = 0; corner < 3; ++corner) {
            const float* at = source.columns + 3 * corner * source.stride + i;
            const V px = hn::LoadU(d, at), py = hn::LoadU(d, at + source.stride),
                    pz = hn::LoadU(d, at + 2 * source.stride);
            const auto row = [&](int r) {
                return hn::MulAdd(
                    set(m[0][r]), px,
                    hn::MulAdd(set(m[1][r]), py, hn::MulAdd(set(m[2][r]), pz, set(source.origin_in_frame[r]))));
            };
            x[corner] = row(0);
            y[corner] = row(1);
            a[corner] = row(2);
        }
        V low, high, nearest, farthest; // slices; radii of the cuts
        const auto least_of = [](const V* v) { return hn::Min(v[0], hn::Min(v[1], v[2])); };
        const auto most_of = [](const V* v) { return hn::Max(v[0], hn::Max(v[1], v[2])); };
        if (frame.is_parallel) {
            low = hn::Sub(least_of(y), set(layout.first_slice));
            high = hn::Sub(most_of(y), set(layout.first_slice));
            nearest = least_of(x);
            farthest = most_of(x);
        } else {
            const Angles angles = angles_of(x, y);
            const V from_first = hn::Sub(angles.low, set(layout.first_slice));
            const V turns = hn::Floor(hn::Mul(from_first, set(1 / turn)));
            low = hn::IfThenElse(angles.is_pierced, hn::Zero(d), hn::NegMulAdd(turns, set(turn), from_first));
            high = hn::IfThenElse(angles.is_pierced, set(turn), hn::Add(low, angles.span));
            V square[3];
            for (int c = 0; c < 3; ++c)
                square[c] = hn::MulAdd(x[c], x[c], hn::Mul(y[c], y[c]));
            // Within an angle of s a chord is never nearer than cos(s / 2) of its nearer end.
            const V sagitta = hn::NegMulAdd(hn::Mul(angles.span, angles.span), set(0.1251f), set(1.0f));
            nearest =
                hn::Max(hn::Mul(hn::Sqrt(least_of(square)), hn::IfThenElseZero(hn::Not(angles.is_pierced), sagitta)),
                        set(layout.smallest_radius_cut));
            farthest = hn::Max(hn::Sqrt(most_of(square)), nearest);
        }
        // A hundredth of a slice of slack for the rounding of angles; the cut itself decides.
        const V first = hn::Ceil(hn::MulSub(low, per_step, set(0.01f))),
                last = hn::Floor(hn::MulAdd(high, per_step, set(0.01f)));
        const auto is_within = [&](V from, V to) {
            return hn::Le(hn::Max(from, first_needed), hn::Min(to, last_needed));
        };
        Mask matters = is_within(first, last);
        if (layout.slices_per_turn > 0)
            matters = hn::Or(matters, is_within(hn::Sub(first, one_turn), hn::Sub(last, one_turn)));
        matters = hn::And(matters, hn::Le(first, last)); // false for a NaN, too
        const V highest = most_of(a);
        const auto slope_at = [&](V r) {
            return hn::Div(linear_at(frame.y, highest, r), linear_at(frame.w, highest, r));
        };
        matters = hn::And(matters, hn::Gt(hn::Max(slope_at(nearest), slope_at(farthest)), set(needs.smallest_slope)));
        if (frame.is_angular) {
            const auto x_at = [&](V along, V r) {
                return hn::Div(linear_at(frame.x, along, r), linear_at(frame.w, along, r));
            };
            const V lowest = least_of(a);
            const V far0 = x_at(lowest, nearest), far1 = x_at(lowest, farthest), near0 = x_at(highest, nearest),
                    near1 = x_at(highest, farthest);
            matters = hn::And(matters, hn::And(hn::Ge(hn::Max(hn::Max(far0, far1), hn::Max(near0, near1)), least_x),
                                               hn::Le(hn::Min(hn::Min(far0, far1), hn::Min(near0, near1)), most_x)));
        } else {
            const V from = hn::Max(nearest, set(needs.first_line)), to = hn::Min(farthest, set(needs.last_line));
            const auto index_at = [&](V r) { return hn::Mul(hn::Sub(r, set(layout.first_line)), per_line); };
            // Between two centres of lines there is nothing to shade.
            matters = hn::And(matters, hn::Le(hn::Ceil(hn::Sub(index_at(from), set(0.51f))),
                                              hn::Floor(hn::Sub(index_at(to), set(0.49f)))));
        }
        if (source.count - i < hn::Lanes(d))
            matters = hn::And(matters, hn::FirstN(d, source.count - i));
        if (hn::AllFalse(d, matters))
            continue;
        const auto keep = [&](V value, PlacedTriangles::Column& column) {
            hn::StoreU(hn::Compress(value, matters), d, &column[placed.count]);
        };
        for (std::size_t corner = 0; corner < 3; ++corner) {
            keep(a[corner], placed.axy[3 * corner]);
            keep(x[corner], placed.axy[3 * corner + 1]);
            keep(y[corner], placed.axy[3 * corner + 2]);
        }
        keep(first, placed.first_slice);
        keep(last, placed.last_slice);
        if (kept != nullptr)
            hn::StoreU(hn::Compress(hn::Add(hn::Iota(di, 0), hn::Set(di, static_cast<std::int32_t>(i))),
                                    hn::RebindMask(di, matters)),
                       di, kept + placed.count);
        placed.count += hn::CountTrue(d, matters);
    }
}
} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::light_shafts {
HWY_EXPORT(place_rays_of);
HWY_EXPORT(place_triangles_of);
} // namespace tyndall::light_shafts

namespace tyndall::light_shafts::slope_rows {
void place_rays(const Frame& frame, std::span<const ViewRay> rays, PlacedRays& placed) {
    if (!rays.empty())
        HWY_DYNAMIC_DISPATCH(place_rays_of)(frame, rays.data(), rays.size(), placed);
}
void place_triangles(const Layout& layout, const SliceNeeds& needs, const TriangleSource& source,
                     PlacedTriangles& placed, std::int32_t* kept) {
    if (source.count > 0)
        HWY_DYNAMIC_DISPATCH(place_triangles_of)(layout, needs, source, placed, kept);
}
} // namespace tyndall::light_shafts::slope_rows
#endif
