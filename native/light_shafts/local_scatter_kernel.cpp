// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/local_scatter_kernel.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "light_shafts/local_scatter_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <hwy/contrib/math/math-inl.h>

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<double, 8>;
using V = hn::Vec<Tag>;
static constexpr Tag d;

/// Points on [-1, 1]; the last weighs nothing and fills the vector. Kronrod's odd ones are Gauss's.
struct Rule {
    alignas(64) double at[16];
    alignas(64) double kronrod[16];
    alignas(64) double gauss[16];
};
constexpr Rule make_rule() {
    constexpr double at[7] = {0.991455371120812639206854697526329, 0.949107912342758524526189684047851,
                              0.864864423359769072789712788640926, 0.741531185599394439863864773280788,
                              0.586087235467691130294144691693384, 0.405845151377397166906606412076961,
                              0.207784955007898467600689403773245};
    constexpr double kronrod[8] = {0.022935322010529224963732008058970, 0.063092092629978553290700663189204,
                                   0.104790010322250183839876322541518, 0.140653259715525918745189590510238,
                                   0.169004726639267902826583426598550, 0.190350578064785409913256402421014,
                                   0.204432940075298892414161999234649, 0.209482141084727828012999174891714};
    constexpr double gauss[4] = {0.129484966168869693270611432679082, 0.279705391489276667901467771423780,
                                 0.381830050505118944950369775488975, 0.417959183673469387755102040816327};
    Rule rule{};
    for (int point = 0; point < 7; ++point) {
        rule.at[point] = at[point], rule.at[14 - point] = -at[point];
        rule.kronrod[point] = rule.kronrod[14 - point] = kronrod[point];
        rule.gauss[point] = rule.gauss[14 - point] = point % 2 == 1 ? gauss[point / 2] : 0.0;
    }
    rule.kronrod[7] = kronrod[7], rule.gauss[7] = gauss[3];
    return rule;
}
static constexpr Rule rule = make_rule();

static HWY_INLINE V set(double value) { return hn::Set(d, value); }

/// start + t * along, one component.
static HWY_INLINE V on_ray(const dvec3& start, const dvec3& along, int axis, V t) {
    return hn::MulAdd(set(along[axis]), t, set(start[axis]));
}

static HWY_INLINE V dot(const V (&p)[3], const dvec3& q) {
    return hn::MulAdd(p[0], set(q.x), hn::MulAdd(p[1], set(q.y), hn::Mul(p[2], set(q.z))));
}

static HWY_INLINE V length2(const V (&p)[3]) {
    return hn::MulAdd(p[0], p[0], hn::MulAdd(p[1], p[1], hn::Mul(p[2], p[2])));
}

static HWY_INLINE V spot_of(const AngularSource::Spot& spot, V t) {
    V p[3];
    for (int axis = 0; axis < 3; ++axis)
        p[axis] = on_ray(spot.start, spot.along, axis, t);
    const V cosine = hn::Div(p[2], hn::Sqrt(length2(p)));
    const V above = hn::Sub(cosine, set(spot.cos_half));
    V share = hn::IfThenElse(hn::Gt(above, hn::Zero(d)), set(1.0), hn::Zero(d)); // 0 for a NaN: at the light itself
    if (spot.per_smooth > 0.0) {
        const V x = hn::Min(hn::Max(hn::Mul(above, set(spot.per_smooth)), hn::Zero(d)), set(1.0));
        share = hn::Mul(share, hn::Mul(hn::Mul(x, x), hn::NegMulAdd(set(2.0), x, set(3.0))));
    }
    if (spot.keeps_cosine)
        share = hn::Mul(share, hn::IfThenElse(hn::Gt(above, hn::Zero(d)), cosine, hn::Zero(d)));
    return share;
}

/// What shapes the light towards each point: cosine lobe, cone, softening; 1 for a point light.
static HWY_INLINE V shape_of(const AngularSource& s, V x, V t, V distance) {
    V shape = set(1.0);
    if (s.has_normal || s.is_soft) {
        V from_light[3];
        for (int axis = 0; axis < 3; ++axis)
            from_light[axis] = on_ray(s.start, s.along, axis, t);
        if (s.has_normal)
            shape = hn::Max(hn::Zero(d), hn::Div(dot(from_light, s.normal), distance));
        if (s.is_soft) {
            for (int axis = 0; axis < 3; ++axis)
                from_light[axis] = hn::Sub(from_light[axis], set(s.falloff_offset[axis]));
            const V softened = hn::MulAdd(x, x, set(s.softened_y * s.softened_y)); // what the angles divide by
            shape = hn::Mul(shape, hn::Div(softened, hn::Add(length2(from_light), set(s.softening_m2))));
        }
    }
    return s.has_spot ? hn::Mul(shape, spot_of(s.spot, t)) : shape;
}

static KronrodSums integrate_angles_of(const AngularSource& s, double from_rad, double to_rad) {
    const double middle = 0.5 * (from_rad + to_rad), half = 0.5 * (to_rad - from_rad);
    V kronrod[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)}, gauss[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
    for (std::size_t first = 0; first < 16; first += hn::Lanes(d)) {
        const V angle = hn::MulAdd(hn::Load(d, rule.at + first), set(half), set(middle));
        const V x = hn::Mul(set(s.softened_y), hn::Div(hn::Sin(d, angle), hn::Cos(d, angle)));
        const V t = hn::Min(hn::Max(hn::Add(x, set(s.light_x)), set(s.near_m)), set(s.far_m));
        const V distance = hn::Sqrt(hn::MulAdd(x, x, set(s.light_y * s.light_y)));
        V light_sigma_t[3] = {set(s.sigma_t_at_light.x), set(s.sigma_t_at_light.y), set(s.sigma_t_at_light.z)};
        for (const AngularSource::Crossing& crossing : s.crossings) {
            const V share =
                hn::Div(hn::NegMulAdd(set(crossing.a), t, set(crossing.c)),
                        hn::MulAdd(set(crossing.a), hn::Sub(set(s.light_x), t), set(crossing.b * s.light_y)));
            for (int channel = 0; channel < 3; ++channel)
                light_sigma_t[channel] =
                    hn::MulAdd(share, set(crossing.signed_sigma_t[channel]), light_sigma_t[channel]);
        }
        // The light's way makes the angle's complement with the ray; on to the camera it goes against it.
        const V cosine = hn::Min(hn::Max(hn::Neg(hn::Div(x, distance)), set(-1.0)), set(1.0));
        V scatter[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
        for (const AngularSource::Lobe& lobe : s.lobes) {
            const V base = hn::NegMulAdd(set(lobe.two_g), cosine, set(lobe.one_plus_g2));
            const V phase = hn::Div(set(1.0), hn::Mul(base, hn::Sqrt(base)));
            for (int channel = 0; channel < 3; ++channel)
                scatter[channel] = hn::MulAdd(phase, set(lobe.weight[channel]), scatter[channel]);
        }
        const V shape = shape_of(s, x, t, distance), along = hn::Sub(t, set(s.near_m));
        V transmittance[3];
        for (int channel = 0; channel < 3; ++channel) {
            if (channel > 0 && s.is_grey) {
                transmittance[channel] = transmittance[0];
                continue;
            }
            const V at_light = hn::Max(light_sigma_t[channel], hn::Zero(d));
            const V depth = hn::MulAdd(set(s.sigma_t[channel]), along,
                                       hn::MulAdd(at_light, distance, set(s.camera_depth_at_near[channel])));
            transmittance[channel] = hn::Exp(d, hn::Neg(hn::Min(depth, set(700.0)))); // 1e-304: as good as 0
        }
        for (int channel = 0; channel < 3; ++channel) {
            const V value = hn::Mul(hn::Mul(shape, scatter[channel]), transmittance[channel]);
            kronrod[channel] = hn::MulAdd(hn::Load(d, rule.kronrod + first), value, kronrod[channel]);
            gauss[channel] = hn::MulAdd(hn::Load(d, rule.gauss + first), value, gauss[channel]);
        }
    }
    const auto sums = [&](const V(&values)[3]) {
        return half * dvec3(hn::GetLane(hn::SumOfLanes(d, values[0])), hn::GetLane(hn::SumOfLanes(d, values[1])),
                            hn::GetLane(hn::SumOfLanes(d, values[2])));
    };
    return {sums(kronrod), sums(gauss)};
}
} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::light_shafts {
HWY_EXPORT(integrate_angles_of);

KronrodSums integrate_angles(const AngularSource& source, double from_rad, double to_rad) {
    return HWY_DYNAMIC_DISPATCH(integrate_angles_of)(source, from_rad, to_rad);
}
} // namespace tyndall::light_shafts
#endif
