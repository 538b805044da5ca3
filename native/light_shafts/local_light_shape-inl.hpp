// SPDX-License-Identifier: GPL-3.0-or-later
// How a local light shines towards points of rays, a ray in each lane, compiled once per SIMD target: its surface's cosine,
// its softening, its spread and its cone.
#if defined(TYNDALL_LOCAL_LIGHT_SHAPE_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TYNDALL_LOCAL_LIGHT_SHAPE_INL
#undef TYNDALL_LOCAL_LIGHT_SHAPE_INL
#else
#define TYNDALL_LOCAL_LIGHT_SHAPE_INL
#endif
#include "light_shafts/exp-inl.hpp"
#include "light_shafts/local_scatter_kernel.hpp"
#include "light_shafts/slope_rows_angle-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<float, 16>;
using V = hn::Vec<Tag>;
using Mask = hn::Mask<Tag>;
static constexpr Tag d;
static constexpr hn::RebindToSigned<Tag> di;
static constexpr std::size_t lanes = hn::MaxLanes(d);

static HWY_INLINE V set(float value) { return hn::Set(d, value); }
static HWY_INLINE V set(double value) { return hn::Set(d, static_cast<float>(value)); }

/// What a vector of rays needs of a light at all its points.
struct LightLanes {
    V light_y2, softened_y2, lobe0, lobe1;
    V cone[3], cone_d[3], offset0, offset_x;
};

/// A local light from a point of the ray.
struct LightView {
    V share;         ///< Lobe, softening, cone and edges.
    V cosine, sine2; ///< Of the angle between the ray and the way that the light has come.
    V distance;      ///< That it has come through.
};

struct LightShape {
    const LocalShape& shape;

    /// view_local of a patch, x from its foot.
    HWY_INLINE LightView area_at(const LightLanes& s, V x, V distance2) const {
        const V softening = set(shape.softening_m2), one = set(1.0f), zero = hn::Zero(d), tiny = set(1e-20f);
        const V p0 = hn::MulAdd(x, s.cone_d[0], s.cone[0]), p1 = hn::MulAdd(x, s.cone_d[1], s.cone[1]);
        const V before = hn::Max(hn::MulAdd(x, s.cone_d[2], s.cone[2]), zero);
        const V softened = hn::Sqrt(hn::MulAdd(before, before, softening));
        const V way2 = hn::Add(distance2, softening), inverse_way = reciprocal_root_of(d, way2);
        const V way = hn::Mul(way2, inverse_way), beside2 = hn::MulAdd(p0, p0, hn::Mul(p1, p1));
        const V edges = edge_share(p0, p1, before, softened), z = hn::Mul(softened, inverse_way);

        LightView view;
        const V lobe = hn::NegMulAdd(set(shape.spread_cotangent), hn::Sqrt(beside2), softened);
        view.share = hn::Mul(hn::Mul(hn::Max(lobe, zero), inverse_way), edges);
        const V nearer = hn::Mul(softening, reciprocal_of(d, hn::Max(hn::Add(softened, before), tiny)));
        view.distance = hn::NegMulAdd(nearer, hn::Sqrt(hn::Div(way, hn::Max(softened, tiny))), way);
        const V stretched = hn::Max(hn::NegMulAdd(hn::Sub(one, z), edges, one), zero);
        const V down = hn::Min(hn::IfThenElse(hn::Gt(edges, one), stretched, hn::Mul(z, edges)), one);
        const V aside =
            hn::Mul(hn::Sqrt(hn::NegMulAdd(down, down, one)), reciprocal_root_of(d, hn::Max(beside2, tiny)));
        const V came0 = hn::Mul(aside, p0), came1 = hn::Mul(aside, p1);
        const auto product = [](V a, V b, V c, V e) { return hn::MulSub(a, b, hn::Mul(c, e)); };
        const V across0 = product(came1, s.cone_d[2], down, s.cone_d[1]),
                across1 = product(down, s.cone_d[0], came0, s.cone_d[2]),
                across2 = product(came0, s.cone_d[1], came1, s.cone_d[0]);
        view.cosine = hn::MulAdd(came0, s.cone_d[0], hn::MulAdd(came1, s.cone_d[1], hn::Mul(down, s.cone_d[2])));
        view.sine2 = hn::MulAdd(across0, across0, hn::MulAdd(across1, across1, hn::Mul(across2, across2)));
        return view;
    }
    /// LocalView::edge_share.
    HWY_INLINE V edge_share(V p0, V p1, V before, V softened) const {
        const V one = set(1.0f);
        const V far = hn::Mul(hn::Mul(before, before), set(1.0 / (far_before_softenings * shape.softening_m2)));
        const V weight = hn::Min(hn::Max(hn::Sub(set(2.0f), far), hn::Zero(d)), one);
        if (hn::AllTrue(d, hn::Eq(weight, hn::Zero(d))))
            return one;
        V x[8], y[8], across2[8];
        for (std::size_t corner = 0; corner < shape.outline.count; ++corner) {
            x[corner] = hn::Sub(set(shape.outline.corners_m[corner].x), p0);
            y[corner] = hn::Sub(set(shape.outline.corners_m[corner].y), p1);
            across2[corner] = hn::MulAdd(x[corner], x[corner], hn::Mul(y[corner], y[corner]));
        }
        const auto half_angle = [&](V height) {
            const V height2 = hn::MulAdd(height, height, set(1e-30f));
            const auto towards = [&](std::size_t corner) {
                return reciprocal_root_of(d, hn::Add(across2[corner], height2));
            };
            const auto cosine = [&](std::size_t a, std::size_t b, V inverse_a, V inverse_b) {
                const V product = hn::MulAdd(x[a], x[b], hn::MulAdd(y[a], y[b], height2));
                return hn::Mul(product, hn::Mul(inverse_a, inverse_b));
            };
            const V first = towards(0);
            V last = towards(1), first_last = cosine(0, 1, first, last), real = one, imaginary = hn::Zero(d);
            for (std::size_t corner = 2; corner < shape.outline.count; ++corner) {
                const V next = towards(corner), first_next = cosine(0, corner, first, next);
                const V own_real =
                    hn::Add(hn::Add(one, first_last), hn::Add(first_next, cosine(corner - 1, corner, last, next)));
                const V twice_area = set(shape.twice_fan_m2[corner - 2]);
                const V own_imaginary = hn::Mul(hn::Mul(twice_area, height), hn::Mul(first, hn::Mul(last, next)));
                const V sum = hn::MulSub(real, own_real, hn::Mul(imaginary, own_imaginary));
                imaginary = hn::MulAdd(real, own_imaginary, hn::Mul(imaginary, own_real));
                real = sum, last = next, first_last = first_next;
            }
            return atan2_of(d, hn::Max(imaginary, hn::Zero(d)), real);
        };
        const V width = set(shape.edge_width);
        const V seen = half_angle(hn::Mul(width, before)), softly = half_angle(hn::Mul(width, softened));
        return hn::MulAdd(weight, hn::Div(hn::Sub(seen, softly), hn::Max(softly, set(1e-30f))), one);
    }
    /// Cosine lobe, softening and cone at a point, of lights that are none of an area light's patches.
    HWY_INLINE V shape_at(const LightLanes& s, V x, V x2, V inverse_distance, V before, V after) const {
        V share = set(1.0f);
        if (shape.has_normal)
            share =
                hn::Mul(hn::Max(hn::MulAdd(before, s.lobe0, hn::Mul(after, s.lobe1)), hn::Zero(d)), inverse_distance);
        if (shape.is_soft) {
            const double offset2 = glm::dot(shape.falloff_offset, shape.falloff_offset) + shape.softening_m2;
            const V way2 =
                hn::Sub(hn::Add(hn::Add(x2, s.light_y2), set(offset2)), hn::MulAdd(x, s.offset_x, s.offset0));
            const V inverse_way2 = reciprocal_of(d, way2);
            share = hn::Mul(share, hn::Mul(hn::Add(x2, s.softened_y2), inverse_way2));
            const V cosine2 = hn::NegMulAdd(set(shape.softening_m2), inverse_way2, set(1.0f)); // at the patch of a disc
            share = shape.faces_receivers ? hn::Mul(share, hn::Sqrt(hn::Max(cosine2, hn::Zero(d)))) : share;
        }
        if (!shape.has_cone)
            return share;
        V p[3];
        for (int axis = 0; axis < 3; ++axis)
            p[axis] = hn::MulAdd(x, s.cone_d[axis], s.cone[axis]);
        const V across2 = hn::MulAdd(p[0], p[0], hn::Mul(p[1], p[1]));
        const V inverse = reciprocal_root_of(d, hn::MulAdd(p[2], p[2], across2));
        const V cosine = hn::Mul(p[2], inverse), one = set(1.0f);
        // sin^2 / (1 + cos): near the axis of a narrow cone 1 - cos would be noise.
        V one_minus_cosine =
            hn::Mul(hn::Mul(across2, hn::Mul(inverse, inverse)), reciprocal_of(d, hn::Add(one, hn::Abs(cosine))));
        one_minus_cosine =
            hn::IfThenElse(hn::Lt(cosine, hn::Zero(d)), hn::Sub(set(2.0f), one_minus_cosine), one_minus_cosine);
        const V above = hn::Sub(set(shape.one_minus_cos_half), one_minus_cosine);
        if (shape.has_soft_edge) {
            const V rise = hn::Min(hn::Max(hn::Mul(above, set(shape.per_smooth)), hn::Zero(d)), one);
            share = hn::Mul(share, hn::Mul(hn::Mul(rise, rise), hn::NegMulAdd(set(2.0f), rise, set(3.0f))));
        } else
            share = hn::IfThenElseZero(hn::Gt(above, hn::Zero(d)), share);
        return shape.keeps_cosine ? hn::Mul(share, hn::Max(cosine, hn::Zero(d))) : share;
    }
};
} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
