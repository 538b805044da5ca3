// SPDX-License-Identifier: GPL-3.0-or-later
// Based on: scene/light.cpp and area_light.cpp, whose strata these are; there is the source of each formula.
// Differs:  the distance to a stratum on a sphere cancels from its irradiance: only the solid angle is left.
#include "render/light_aim.hpp"
#include "core/sampling.hpp"
#include "render/pixel_samples.hpp"
#include "scene/light_axes.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/light_aim.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "light_shafts/slope_rows_angle-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tyndall::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using Form = LightAim::Form;
using Tag = hn::CappedTag<float, lane_count>;
using V = hn::Vec<Tag>;
using Mask = hn::Mask<Tag>;
static constexpr Tag d;

struct V3 {
    V x, y, z;
};
static HWY_INLINE V set(float value) { return hn::Set(d, value); }
static HWY_INLINE V3 set(const vec3& value) { return {set(value.x), set(value.y), set(value.z)}; }
static HWY_INLINE V3 load(const Lanes3& lanes, std::size_t at) {
    return {hn::Load(d, &lanes.x[at]), hn::Load(d, &lanes.y[at]), hn::Load(d, &lanes.z[at])};
}
static HWY_INLINE void store(const V3& value, Lanes3& lanes, std::size_t at) {
    hn::Store(value.x, d, &lanes.x[at]);
    hn::Store(value.y, d, &lanes.y[at]);
    hn::Store(value.z, d, &lanes.z[at]);
}
static HWY_INLINE V3 subtract(const V3& a, const V3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
/// a + s b
static HWY_INLINE V3 along(const V3& a, V s, const V3& b) {
    return {hn::MulAdd(s, b.x, a.x), hn::MulAdd(s, b.y, a.y), hn::MulAdd(s, b.z, a.z)};
}
static HWY_INLINE V3 scaled(V s, const V3& a) { return {s * a.x, s * a.y, s * a.z}; }
static HWY_INLINE V dot(const V3& a, const V3& b) { return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, a.z * b.z)); }
static HWY_INLINE LaneSet bits_of(Mask mask, std::size_t at) {
    std::array<std::uint8_t, 8> bytes{};
    hn::StoreMaskBits(d, mask, bytes.data());
    return static_cast<LaneSet>(bytes[0] | bytes[1] << 8) << at;
}

/// orthonormal_basis of core/math.hpp, and a vector given in it.
static HWY_INLINE V3 from_frame(const V3& axis, V x, V y, V z) {
    const V sign = hn::CopySign(set(1.0f), axis.z);
    const V a = hn::Neg(set(1.0f) / (sign + axis.z));
    const V b = axis.x * axis.y * a;
    const V3 tangent{hn::MulAdd(sign * axis.x * axis.x, a, set(1.0f)), sign * b, hn::Neg(sign * axis.x)};
    const V3 bitangent{b, hn::MulAdd(axis.y * axis.y, a, sign), hn::Neg(axis.y)};
    return along(along(scaled(z, axis), y, bitangent), x, tangent);
}

struct V2 {
    V x, y;
};
/// sample_concentric_disc of core/sampling.hpp; the angle is at most pi / 4, where short series suffice.
static HWY_INLINE V2 concentric_disc(V ux, V uy) {
    const V x = hn::MulSub(set(2.0f), ux, set(1.0f)), y = hn::MulSub(set(2.0f), uy, set(1.0f));
    const Mask is_wide = hn::Gt(hn::Abs(x), hn::Abs(y));
    const V radius = hn::IfThenElse(is_wide, x, y), other = hn::IfThenElse(is_wide, y, x);
    const Mask is_centre = hn::Eq(radius, hn::Zero(d));
    const V ratio = hn::IfThenZeroElse(is_centre, other / hn::IfThenElse(is_centre, set(1.0f), radius));
    const V angle = set(0.25f * std::numbers::pi_v<float>) * ratio;
    const V a2 = angle * angle;
    V sine = hn::MulAdd(a2, set(1.0f / 362880.0f), set(-1.0f / 5040.0f));
    sine = hn::MulAdd(a2, sine, set(1.0f / 120.0f));
    sine = hn::MulAdd(a2, sine, set(-1.0f / 6.0f));
    sine = hn::MulAdd(a2 * angle, sine, angle);
    V cosine = hn::MulAdd(a2, set(-1.0f / 3628800.0f), set(1.0f / 40320.0f));
    cosine = hn::MulAdd(a2, cosine, set(-1.0f / 720.0f));
    cosine = hn::MulAdd(a2, cosine, set(1.0f / 24.0f));
    cosine = hn::MulAdd(a2, cosine, set(-0.5f));
    cosine = hn::MulAdd(a2, cosine, set(1.0f));
    return {radius * hn::IfThenElse(is_wide, cosine, sine), radius * hn::IfThenElse(is_wide, sine, cosine)};
}
#include "render/light_aim_area-inl.hpp"

struct InCone {
    V3 direction;
    V one_minus_cos; ///< Between it and the axis.
};
/// sample_uniform_cone around an axis.
static HWY_INLINE InCone direction_in_cone(const V3& axis, const V2& disc, V cone) {
    const V one_minus_cos = hn::Min(set(1.0f), hn::MulAdd(disc.x, disc.x, disc.y * disc.y)) * cone;
    const V stretch = hn::Sqrt(cone * (set(2.0f) - one_minus_cos));
    return {from_frame(axis, stretch * disc.x, stretch * disc.y, set(1.0f) - one_minus_cos), one_minus_cos};
}

LaneSet may_light_of(const Form& form, const LitPoints& points) {
    LaneSet lanes = 0;
    for (std::size_t at = 0; at < lane_count; at += hn::Lanes(d)) {
        const V3 normal = load(points.shading_normal, at);
        if (form.kind == Form::Kind::SunCone || form.kind == Form::Kind::SunDisc) {
            lanes |= bits_of(hn::Gt(dot(set(form.towards_light), normal), set(-form.margin)), at);
            continue;
        }
        if (form.kind == Form::Kind::Area) {
            lanes |= bits_of(may_area_light(form, load(points.position, at), normal), at);
            continue;
        }
        const V3 way = subtract(load(points.position, at), set(form.position));
        Mask may = hn::Lt(dot(way, normal), set(form.margin));
        if (form.is_spot) {
            // Whether the sphere in which the light stands meets the cone that opens from the point to all places from
            // which the spot would shine on it: the same cone as the light's, turned round.
            const mat3& matrix = form.cone_from_world;
            const V3 in_cone =
                along(along(scaled(way.x, set(matrix[0])), way.y, set(matrix[1])), way.z, set(matrix[2]));
            const V across2 = hn::MulAdd(in_cone.x, in_cone.x, in_cone.y * in_cone.y);
            const V outside_by = hn::MulAdd(hn::Sqrt(across2), set(form.cos_half), in_cone.z * set(form.sin_half));
            const V rounding = set(1e-5f) * hn::Sqrt(hn::MulAdd(in_cone.z, in_cone.z, across2));
            may = hn::And(may, hn::Le(outside_by, set(form.cone_radius) + rounding));
        }
        lanes |= bits_of(may, at);
    }
    return lanes & points.present;
}

void draw_pairs_of(const LitPoints& points, const PairIndex& pair, Lanes& ux, Lanes& uy) {
    for (std::size_t lane = 0; lane < lane_count; ++lane) { // the compiler makes vector code of it
        const vec2 u = pixel_pair(points.pixel_seeds[lane], pair.sample_index, pair.pair_index);
        ux[lane] = u.x;
        uy[lane] = u.y;
    }
}

static HWY_INLINE Mask aim_sun(const Form& form, const V2& disc, const V3& normal, V3& direction, V& weight) {
    const V3 axis = set(form.towards_light);
    if (form.kind == Form::Kind::SunCone) {
        direction = direction_in_cone(axis, disc, set(form.cone)).direction;
    } else {
        const V3 flat = from_frame(axis, set(form.cone) * disc.x, set(form.cone) * disc.y, set(1.0f));
        direction = scaled(set(1.0f) / hn::Sqrt(dot(flat, flat)), flat);
    }
    const V cosine = dot(normal, direction);
    weight = set(form.weight) * cosine;
    return hn::Gt(cosine, hn::Zero(d));
}

/// `target`: the point on the light.
static HWY_INLINE Mask aim_local(const Form& form, const V2& disc, const V3& position, const V3& normal, V3& target,
                                 V& weight) {
    const V3 centre = set(form.position), way = subtract(centre, position);
    const V distance2 = dot(way, way), distance_m = hn::Sqrt(distance2), one = set(1.0f);
    const Mask has_direction = hn::Gt(distance_m, hn::Zero(d));
    const V3 axis = scaled(one / hn::IfThenElse(has_direction, distance_m, one), way);
    const V radius_m = set(form.radius_m);
    // Of the centre: a light without a size, and a sphere with the point inside.
    const V falloff_of_centre = one / hn::IfThenElse(has_direction, distance2, one);
    V3 direction = axis;
    V falloff = falloff_of_centre;
    target = centre;
    if (form.radius_m > 0.0f && form.kind == Form::Kind::Sphere) {
        const Mask is_outside = hn::Gt(distance_m, radius_m);
        const V sine = hn::IfThenElseZero(is_outside, radius_m / distance_m), sine2 = sine * sine;
        const V cone = sine2 / (one + hn::Sqrt(one - sine2));
        const auto [sampled, one_minus_cos] = direction_in_cone(axis, disc, cone);
        const V sampled_sine2 = one_minus_cos * (set(2.0f) - one_minus_cos);
        const V half_chord2 = hn::Max(hn::Zero(d), hn::NegMulAdd(distance2, sampled_sine2, radius_m * radius_m));
        const V to_surface_m = distance_m * (one - one_minus_cos) - hn::Sqrt(half_chord2);
        const V3 on_sphere = along(position, to_surface_m, sampled);
        const auto choose = [&](const V3& a, const V3& b) {
            return V3{hn::IfThenElse(is_outside, a.x, b.x), hn::IfThenElse(is_outside, a.y, b.y),
                      hn::IfThenElse(is_outside, a.z, b.z)};
        };
        direction = choose(sampled, axis);
        target = choose(on_sphere, centre);
        falloff = hn::IfThenElse(is_outside, set(2.0f / (form.radius_m * form.radius_m)) * cone, falloff_of_centre);
    } else if (form.radius_m > 0.0f) {
        target = along(centre, radius_m, from_frame(scaled(set(-1.0f), axis), disc.x, disc.y, hn::Zero(d)));
        const V3 to_target = subtract(target, position);
        const V length2 = dot(to_target, to_target);
        direction = scaled(one / hn::Sqrt(hn::IfThenElse(has_direction, length2, one)), to_target);
        falloff = hn::Max(hn::Zero(d), dot(axis, direction)) / hn::IfThenElse(has_direction, length2, one);
    }
    const V cosine = dot(normal, direction);
    weight = falloff * cosine;
    return hn::And(has_direction, hn::Gt(cosine, hn::Zero(d)));
}

static HWY_INLINE V3 spawned(const LitPoints& points, const V3& direction, std::size_t at) {
    const V3 away = load(points.spawn_normal, at);
    const V offset_m = hn::CopySign(hn::Load(d, &points.spawn_offset_m[at]), dot(direction, away));
    return along(load(points.spawn_position, at), offset_m, away);
}

LaneSet aim_at_world_of(const LitPoints& points, const Lanes& ux, const Lanes& uy, AimedRays& rays) {
    LaneSet lanes = 0;
    for (std::size_t at = 0; at < lane_count; at += hn::Lanes(d)) {
        const V2 disc = concentric_disc(hn::Load(d, &ux[at]), hn::Load(d, &uy[at]));
        const V radius2 = hn::MulAdd(disc.x, disc.x, disc.y * disc.y);
        const V cosine = hn::Sqrt(hn::Max(hn::Zero(d), set(1.0f) - radius2));
        const V3 direction = from_frame(load(points.shading_normal, at), disc.x, disc.y, cosine);
        store(spawned(points, direction, at), rays.origin, at);
        store(direction, rays.direction, at);
        hn::Store(set(std::numeric_limits<float>::infinity()), d, &rays.far_m[at]);
        hn::Store(cosine, d, &rays.weight[at]);
        lanes |= bits_of(hn::Gt(cosine, hn::Zero(d)), at);
    }
    return lanes & points.present;
}

LaneSet aim_of(const Form& form, const LitPoints& points, const Lanes& ux, const Lanes& uy, AimedRays& rays) {
    LaneSet lanes = 0;
    const bool is_sun = form.kind == Form::Kind::SunCone || form.kind == Form::Kind::SunDisc;
    for (std::size_t at = 0; at < lane_count; at += hn::Lanes(d)) {
        const V2 square{hn::Load(d, &ux[at]), hn::Load(d, &uy[at])}, disc = concentric_disc(square.x, square.y);
        const V3 position = load(points.position, at), normal = load(points.shading_normal, at);
        V3 direction, target;
        V weight;
        Mask arrives;
        if (is_sun) {
            arrives = aim_sun(form, disc, normal, direction, weight);
        } else {
            arrives = form.kind == Form::Kind::Area ? aim_area(form, square, disc, position, normal, target, weight)
                                                    : aim_local(form, disc, position, normal, target, weight);
            direction = subtract(target, position);
        }
        const V3 origin = spawned(points, direction, at);
        V far_m = set(std::numeric_limits<float>::infinity());
        if (!is_sun) {
            const V3 way = subtract(target, origin);
            far_m = hn::Sqrt(dot(way, way));
            arrives = hn::And(arrives, hn::Gt(far_m, hn::Zero(d)));
            direction = scaled(set(1.0f) / far_m, way);
        }
        store(origin, rays.origin, at);
        store(direction, rays.direction, at);
        hn::Store(far_m, d, &rays.far_m[at]);
        hn::Store(weight, d, &rays.weight[at]);
        lanes |= bits_of(hn::And(arrives, hn::Gt(weight, hn::Zero(d))), at);
    }
    return lanes & points.present;
}
} // namespace tyndall::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::render {
HWY_EXPORT(may_light_of);
HWY_EXPORT(draw_pairs_of);
HWY_EXPORT(aim_of);
HWY_EXPORT(aim_at_world_of);

/// An upper bound of how much a matrix lengthens a vector.
static float largest_stretch(const mat3& matrix) {
    return std::sqrt(glm::dot(matrix[0], matrix[0]) + glm::dot(matrix[1], matrix[1]) + glm::dot(matrix[2], matrix[2]));
}

static LightAim::Form form_of(const Light& light) {
    using Kind = LightAim::Form::Kind;
    constexpr float with_rounding = 1.0f + 1e-5f;
    LightAim::Form form{};
    form.is_spot = light.kind == LightKind::Spot;
    form.position = light.position;
    form.towards_light = light.towards_light;
    form.radius_m = light.radius_m;
    const bool is_disc = light.body == LightBody::FacingDisc;
    if (light.kind == LightKind::Sun) {
        form.margin = 1e-5f + std::sin(std::min(light.half_angle_rad, 0.5f * std::numbers::pi_v<float>));
        form.kind = is_disc ? Kind::SunDisc : Kind::SunCone;
        const float half_angle_rad = is_disc ? std::min(light.half_angle_rad, 1.57f) : light.half_angle_rad;
        const float cos_half = std::cos(half_angle_rad);
        form.cone = is_disc ? std::tan(half_angle_rad) : one_minus_cos(half_angle_rad);
        form.weight = is_disc ? (1.0f + cos_half) / (2.0f * cos_half) : 2.0f / (2.0f - form.cone);
        return form;
    }
    if (light.kind == LightKind::Area) {
        form.kind = Kind::Area;
        form.margin = 1e-5f * glm::length(light.half_size_m);
        form.area_axes = light_axes(light);
        form.half_size_m = light.half_size_m;
        form.per_area_m2 = 1.0f / area_m2(light);
        form.spread = area_spread(light);
        form.is_ellipse = light.is_ellipse;
        return form;
    }
    form.kind = is_disc ? Kind::FacingDisc : Kind::Sphere;
    form.margin = light.radius_m * with_rounding;
    if (!form.is_spot)
        return form;
    form.cone_from_world = light.light_from_world_directions;
    if (light.spot_falloff == SpotFalloff::Blender3) {
        const auto [tangent, bitangent] = orthonormal_basis(-light.spot_axis);
        form.cone_from_world = glm::transpose(mat3(tangent, bitangent, -light.spot_axis));
    }
    form.cone_radius = largest_stretch(form.cone_from_world) * form.margin;
    form.cos_half = std::cos(light.spot_half_angle_rad);
    form.sin_half = std::sin(light.spot_half_angle_rad);
    return form;
}

void LitPoints::set(std::size_t lane, const vec3& at, const vec3& normal, const SpawnPoint& spawn,
                    std::uint32_t pixel_seed) {
    position.set(lane, at);
    shading_normal.set(lane, normal);
    spawn_position.set(lane, spawn.position);
    spawn_normal.set(lane, spawn.normal);
    spawn_offset_m[lane] = spawn.offset_m;
    pixel_seeds[lane] = pixel_seed;
    present |= LaneSet{1} << lane;
}

LightAim::LightAim(const Light& light)
    : form_(form_of(light)),
      has_size_(light.kind == LightKind::Sun ? light.half_angle_rad > 0.0f
                                             : light.kind == LightKind::Area || light.radius_m > 0.0f) {}

LaneSet LightAim::may_light(const LitPoints& points) const { return HWY_DYNAMIC_DISPATCH(may_light_of)(form_, points); }

LaneSet LightAim::aim(const LitPoints& points, const PairIndex& pair, AimedRays& rays) const {
    Lanes ux{}, uy{};
    if (has_size_)
        HWY_DYNAMIC_DISPATCH(draw_pairs_of)(points, pair, ux, uy);
    return HWY_DYNAMIC_DISPATCH(aim_of)(form_, points, ux, uy, rays);
}

LaneSet LightAim::aim_at_world(const LitPoints& points, const PairIndex& pair, AimedRays& rays) {
    Lanes ux{}, uy{};
    HWY_DYNAMIC_DISPATCH(draw_pairs_of)(points, pair, ux, uy);
    return HWY_DYNAMIC_DISPATCH(aim_at_world_of)(points, ux, uy, rays);
}
} // namespace tyndall::render
#endif
