// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/glow_cells.hpp"
#include "volume/phase_function.hpp"
#include <cmath>
#include <numbers>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/glow_cells.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <hwy/contrib/math/math-inl.h>

HWY_BEFORE_NAMESPACE();
namespace tyndall::render::HWY_NAMESPACE {
#include "render/arctangent-inl.hpp"
namespace hn = hwy::HWY_NAMESPACE;
using CellTag = hn::CappedTag<float, 16>;
using Cells = hn::Vec<CellTag>;
static constexpr CellTag cd;

/// Squared distance, in radii, from which a triangle is as good as a point.
static constexpr float near_radii2 = 9.0f;

static HWY_INLINE Cells all(float value) { return hn::Set(cd, value); }
static HWY_INLINE Cells dot3(Cells ax, Cells ay, Cells az, Cells bx, Cells by, Cells bz) {
    return hn::MulAdd(ax, bx, hn::MulAdd(ay, by, az * bz));
}

/// From a point of the line to a place that lies `from_origin` from the line's origin.
struct Way {
    Cells x, y, z;
    HWY_INLINE Way(const vec3& from_origin, const vec3& direction, Cells at_m)
        : x(hn::NegMulAdd(at_m, all(direction.x), all(from_origin.x))),
          y(hn::NegMulAdd(at_m, all(direction.y), all(from_origin.y))),
          z(hn::NegMulAdd(at_m, all(direction.z), all(from_origin.z))) {}
    HWY_INLINE Cells dot(const Way& other) const { return dot3(x, y, z, other.x, other.y, other.z); }
    HWY_INLINE Cells dot(const vec3& other) const { return dot3(x, y, z, all(other.x), all(other.y), all(other.z)); }
};

static HWY_INLINE Cells solid_angle_sr(const EmissiveTriangle& triangle, const MediaLine& line, Cells at_m) {
    const auto& corners = triangle.corners;
    const Way a(corners[0] - line.origin(), line.direction(), at_m),
        b(corners[1] - line.origin(), line.direction(), at_m), c(corners[2] - line.origin(), line.direction(), at_m);
    const Cells length_a = hn::Sqrt(a.dot(a)), length_b = hn::Sqrt(b.dot(b)), length_c = hn::Sqrt(c.dot(c));
    const Cells over = hn::Abs(dot3(a.x, a.y, a.z, hn::MulSub(b.y, c.z, b.z * c.y), hn::MulSub(b.z, c.x, b.x * c.z),
                                    hn::MulSub(b.x, c.y, b.y * c.x)));
    const Cells under = hn::MulAdd(length_a * length_b, length_c,
                                   hn::MulAdd(a.dot(b), length_c, hn::MulAdd(a.dot(c), length_b, b.dot(c) * length_a)));
    return all(2.0f) * arctangent(cd, over, under);
}

/// What covers it of the sky, or of a lamp as if it shone from there in all directions.
static HWY_INLINE Cells seen_sr(const GlowBesideLine& glow, const MediaLine& line, Cells at_m, const Way& way,
                                Cells distance2) {
    if (glow.triangle == nullptr)
        return all(1.0f) / (distance2 + all(glow.radius2));
    const Cells far =
        all(glow.triangle->area_m2) * hn::Abs(way.dot(glow.triangle->normal)) / (distance2 * hn::Sqrt(distance2));
    const auto is_near = hn::Lt(distance2, all(near_radii2 * glow.radius2));
    return hn::AllFalse(cd, is_near) ? far : hn::IfThenElse(is_near, solid_angle_sr(*glow.triangle, line, at_m), far);
}

static HWY_INLINE Cells scattered_per_m_sr(std::span<const MediaLine::Lobe> lobes, Cells cosine) {
    Cells sum = hn::Zero(cd);
    for (const auto& [sigma_s_per_m, asymmetry_g, draine_alpha] : lobes) {
        // As henyey_greenstein_per_sr and draine_per_sr.
        const float g = std::abs(asymmetry_g);
        const Cells forward = all(std::copysign(1.0f, asymmetry_g)) * cosine;
        const Cells below = hn::MulAdd(all(2.0f * g), all(1.0f) - forward, all((1.0f - g) * (1.0f - g)));
        const float peak =
            (1.0f - g) * (1.0f + g) * 0.25f * std::numbers::inv_pi_v<float> / draine_total(asymmetry_g, draine_alpha);
        const Cells factor = hn::MulAdd(all(draine_alpha) * cosine, cosine, all(1.0f));
        sum = hn::MulAdd(all(sigma_s_per_m * peak), factor / (below * hn::Sqrt(below)), sum);
    }
    return sum;
}

/// Of what is scattered there, the mean share of the three channels that the camera sees.
static HWY_INLINE Cells passing(const GlowBesideLine& glow, const MediaLine::Piece& piece, Cells at_m) {
    const auto& [first, second] = glow.light_side;
    const auto is_second = hn::Ge(at_m, all(second.at_m));
    const auto depth = [&](int channel) HWY_ATTR {
        const Cells of_camera =
            hn::MulAdd(at_m - all(piece.near_m), all(piece.sigma_t_per_m[channel]), all(piece.depth[channel]));
        if (!glow.is_dimmed)
            return of_camera;
        const auto of_light = [&](const GlowBesideLine::DepthFrom& from) HWY_ATTR {
            return hn::MulAdd(at_m - all(from.at_m), all(from.per_m[channel]), all(from.depth[channel]));
        };
        return of_camera + hn::IfThenElse(is_second, of_light(second), of_light(first));
    };
    const auto is_grey = [](const Rgb& value) { return value.x == value.y && value.y == value.z; };
    const Cells red = hn::Exp(cd, hn::Neg(depth(0)));
    if (is_grey(piece.depth) && is_grey(piece.sigma_t_per_m) &&
        (!glow.is_dimmed || (is_grey(first.depth) && is_grey(second.depth) && is_grey(second.per_m))))
        return red;
    return all(1.0f / 3.0f) * (red + hn::Exp(cd, hn::Neg(depth(1))) + hn::Exp(cd, hn::Neg(depth(2))));
}

/// The cells of one piece, `count` of them: reads and writes a vector's width past the last one at most.
void weigh_of(const MediaLine& line, const GlowBesideLine& glow, const MediaLine::Piece& piece, std::size_t count,
              const float* from, const float* to, float* angles, float* weights) {
    const Cells one = all(1.0f), zero = hn::Zero(cd);
    for (std::size_t at = 0; at < count; at += hn::Lanes(cd)) {
        const Cells from_x = hn::LoadU(cd, from + at), to_x = hn::LoadU(cd, to + at);
        // Half of the angle between (1, from) and (1, to), by its tangent: an eighth of half a circle at most.
        const Cells lengths = hn::Sqrt(hn::MulAdd(from_x, from_x, one) * hn::MulAdd(to_x, to_x, one));
        const Cells half = (to_x - from_x) / (hn::MulAdd(from_x, to_x, one) + lengths), half2 = half * half;
        Cells series = all(1.0f / 7.0f) - half2 * all(1.0f / 9.0f); // what is left out is below 1e-7
        series = hn::NegMulAdd(half2, series, all(0.2f));
        series = hn::NegMulAdd(half2, series, all(1.0f / 3.0f));
        const auto exists = hn::Gt(half, zero);
        const Cells angle = hn::IfThenElseZero(exists, all(2.0f) * half * hn::NegMulAdd(half2, series, one));
        const Cells turned = (from_x + half) / hn::NegMulAdd(from_x, half, one);
        const Cells middle_x = hn::Min(hn::Max(turned, from_x), to_x);
        const Cells at_m = hn::MulAdd(all(glow.off_m), middle_x, all(glow.foot_m));

        const Way way(glow.from_origin, line.direction(), at_m);
        const Cells distance2 = way.dot(way);
        const Cells cosine = way.dot(line.direction()) / hn::Sqrt(distance2); // back along both: 1 is straight on
        const Cells brightness = seen_sr(glow, line, at_m, way, distance2) *
                                 scattered_per_m_sr(line.lobes_of(piece), cosine) * passing(glow, piece, at_m);
        const Cells weight = brightness * hn::MulAdd(middle_x, middle_x, one) * angle;
        const auto is_seen = hn::And(exists, hn::And(hn::Gt(distance2, zero), hn::IsFinite(weight)));
        hn::StoreU(angle, cd, angles + at);
        hn::StoreU(hn::IfThenElseZero(is_seen, weight), cd, weights + at);
    }
}
} // namespace tyndall::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::render {
HWY_EXPORT(weigh_of);
static constexpr std::size_t most_lanes = 16;

void GlowCells::clear() { pieces_.clear(), from_x_.clear(), to_x_.clear(); }

void GlowCells::append(const MediaLine::Piece& piece, float from_x, float to_x) {
    pieces_.push_back(&piece);
    from_x_.push_back(from_x);
    to_x_.push_back(to_x);
}

void GlowCells::weigh(const MediaLine& line, const GlowBesideLine& glow) {
    for (std::vector<float>* values : {&from_x_, &to_x_, &angle_rad_, &weight_})
        values->resize(size() + most_lanes);
    for (std::size_t first = 0, end = 0; first < size(); first = end) {
        for (end = first + 1; end < size() && pieces_[end] == pieces_[first];)
            ++end;
        HWY_DYNAMIC_DISPATCH(weigh_of)
        (line, glow, *pieces_[first], end - first, &from_x_[first], &to_x_[first], &angle_rad_[first], &weight_[first]);
    }
}
} // namespace tyndall::render
#endif
