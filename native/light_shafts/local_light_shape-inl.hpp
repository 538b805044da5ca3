// SPDX-License-Identifier: GPL-3.0-or-later
// How a local light shines towards points of rays, a ray in each lane, compiled once per SIMD target: its surface's cosine,
// its softening, patches of surfaces (softened_patch.hpp), its spread and its cone.
#if defined(TYNDALL_LOCAL_LIGHT_SHAPE_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TYNDALL_LOCAL_LIGHT_SHAPE_INL
#undef TYNDALL_LOCAL_LIGHT_SHAPE_INL
#else
#define TYNDALL_LOCAL_LIGHT_SHAPE_INL
#endif
#include "light_shafts/exp-inl.hpp"
#include "light_shafts/local_scatter_kernel.hpp"
#include "light_shafts/slope_rows_angle-inl.hpp"
#include <algorithm>

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
    V light_y2, softened_y2, lobe0, lobe1, normal_d;
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

    /// view_local of a softened patch, x from its foot; `normal_m`: of the point over the plane of a patch of a sphere.
    HWY_INLINE LightView patch_at(const LightLanes& s, V x, V distance2, V normal_m) const {
        const V one = set(1.0f), zero = hn::Zero(d), tiny = set(1e-20f), softening = set(shape.softening_m2);
        // Of the axis off the lamp: the way to the point along it, the ray's direction, and how far before it the point lies.
        V off_m, off_d, before, beside2, p0 = zero, p1 = zero, middle = zero, radius = zero, is_outside = one;
        if (shape.is_area) {
            p0 = hn::MulAdd(x, s.cone_d[0], s.cone[0]), p1 = hn::MulAdd(x, s.cone_d[1], s.cone[1]);
            before = off_m = hn::Max(hn::MulAdd(x, s.cone_d[2], s.cone[2]), zero), off_d = s.cone_d[2];
            beside2 = hn::MulAdd(p0, p0, hn::Mul(p1, p1)); // as a difference it would be noise to a narrow spread
        } else {
            radius = set(shape.sphere_radius_m);
            const V square = hn::MulAdd(hn::Add(radius, radius), normal_m, distance2); // above the sphere
            const V middle2 = hn::Max(hn::MulAdd(radius, radius, square), tiny),
                    inverse = reciprocal_root_of(d, middle2);
            middle = hn::Mul(middle2, inverse);
            off_m = hn::Mul(hn::MulAdd(radius, normal_m, distance2), inverse);
            off_d = hn::Mul(hn::MulAdd(radius, s.normal_d, x), inverse);
            before = hn::Max(hn::Mul(square, reciprocal_of(d, hn::Add(middle, radius))), zero);
            beside2 = hn::Max(hn::NegMulAdd(off_m, off_m, distance2), zero);
            is_outside = hn::IfThenElseZero(hn::Gt(square, zero), one);
        }
        const V softened = hn::Sqrt(hn::MulAdd(before, before, softening));
        const V nearer = hn::Mul(softening, reciprocal_of(d, hn::Max(hn::Add(softened, before), tiny)));
        const V lifted2 = hn::MulAdd(nearer, hn::MulAdd(set(2.0f), off_m, nearer), distance2);
        const V inverse = reciprocal_root_of(d, lifted2), lifted = hn::Mul(lifted2, inverse);
        const V z = hn::Mul(hn::Add(off_m, nearer), inverse);
        const V far =
            hn::Mul(hn::Mul(before, before), set(std::min(1e30, 1.0 / (far_before_softenings * shape.softening_m2))));
        const V fade = hn::Min(hn::Max(hn::Sub(set(2.0f), far), zero), one);

        LightView view;
        V angles = one, lobe;
        if (shape.is_area) {
            angles = hn::AllTrue(d, hn::Eq(fade, zero)) ? one : area_angles(p0, p1, before, softened);
            lobe = hn::NegMulAdd(set(shape.spread_cotangent), hn::Sqrt(beside2), softened);
        } else {
            angles = sphere_angles(radius, before, softened);
            const V normal_off = hn::Mul(hn::Add(normal_m, radius), reciprocal_of(d, middle));
            lobe = hn::MulAdd(nearer, normal_off, normal_m);
        }
        angles = hn::Mul(is_outside, hn::MulAdd(fade, hn::Sub(angles, one), one));
        const V measure = hn::Mul(hn::MulAdd(x, x, s.softened_y2), hn::Mul(inverse, inverse));
        view.share = hn::Mul(hn::Mul(hn::Max(lobe, zero), inverse), hn::Mul(angles, measure));
        view.distance = hn::NegMulAdd(nearer, hn::Sqrt(hn::Div(lifted, hn::Max(softened, tiny))), lifted);
        const V stretched = hn::Max(hn::NegMulAdd(hn::Sub(one, z), angles, one), zero);
        const V off = hn::Min(hn::IfThenElse(hn::Gt(angles, one), stretched, hn::Mul(z, angles)), one);
        const V aside = hn::Mul(hn::Sqrt(hn::NegMulAdd(off, off, one)), reciprocal_root_of(d, hn::Max(beside2, tiny)));
        view.cosine = hn::MulAdd(off, off_d, hn::Mul(aside, hn::NegMulAdd(off_m, off_d, x)));
        view.sine2 = hn::Max(hn::NegMulAdd(view.cosine, view.cosine, one), zero);
        return view;
    }
    /// Of the half angles in which two points see a sphere's cap.
    HWY_INLINE V sphere_angles(V radius, V before, V softened) const {
        const V one = set(1.0f);
        const auto cap = [&](V height) {
            const V sine = hn::Div(radius, hn::Add(radius, height)), sine2 = hn::Mul(sine, sine);
            return hn::Div(sine2, hn::Add(one, hn::Sqrt(hn::Max(hn::Sub(one, sine2), hn::Zero(d)))));
        };
        return hn::Div(cap(before), cap(softened));
    }
    /// Of the half angles in which two points, (p0, p1) beside the patch, see an area light.
    HWY_INLINE V area_angles(V p0, V p1, V before, V softened) const {
        const V one = set(1.0f);
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
        return hn::Div(seen, hn::Max(softly, set(1e-30f)));
    }
    /// Cosine lobe and softening at a point, of what is no softened patch.
    HWY_INLINE V shape_at(const LightLanes& s, V x, V x2, V inverse_distance, V normal_m) const {
        V share = set(1.0f);
        if (shape.has_normal)
            share = hn::Mul(hn::Max(normal_m, hn::Zero(d)), inverse_distance);
        if (shape.is_soft) {
            const double offset2 = glm::dot(shape.falloff_offset, shape.falloff_offset) + shape.softening_m2;
            const V way2 =
                hn::Sub(hn::Add(hn::Add(x2, s.light_y2), set(offset2)), hn::MulAdd(x, s.offset_x, s.offset0));
            const V inverse_way2 = reciprocal_of(d, way2);
            share = hn::Mul(share, hn::Mul(hn::Add(x2, s.softened_y2), inverse_way2));
            const V cosine2 = hn::NegMulAdd(set(shape.softening_m2), inverse_way2, set(1.0f)); // at the patch of a disc
            share = shape.faces_receivers ? hn::Mul(share, hn::Sqrt(hn::Max(cosine2, hn::Zero(d)))) : share;
        }
        return share;
    }
    /// `share` in the cone of a spot light.
    HWY_INLINE V cone_at(const LightLanes& s, V x, V share) const {
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
