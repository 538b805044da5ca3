// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/local_support.hpp"
#include "scene/light_axes.hpp"
#include <algorithm>
#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "light_shafts/local_support.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<double, LocalRays::padding>;
using V = hn::Vec<Tag>;
static constexpr Tag d;
static constexpr hn::Rebind<float, Tag> df;

static HWY_INLINE V set(double value) { return hn::Set(d, value); }

struct V3 {
    V x, y, z;
};
static HWY_INLINE V dot(const V3& p, const V3& q) {
    return hn::MulAdd(p.x, q.x, hn::MulAdd(p.y, q.y, hn::Mul(p.z, q.z)));
}
static HWY_INLINE V dot(const dvec3& p, const V3& q) {
    return hn::MulAdd(set(p.x), q.x, hn::MulAdd(set(p.y), q.y, hn::Mul(set(p.z), q.z)));
}
static HWY_INLINE V3 product(const glm::dmat3& m, const V3& p) {
    return {dot(dvec3(m[0].x, m[1].x, m[2].x), p), dot(dvec3(m[0].y, m[1].y, m[2].y), p),
            dot(dvec3(m[0].z, m[1].z, m[2].z), p)};
}

struct Interval {
    V begin, end;
};
/// Where q + x v lies in the cone around +Z with this cosine, [0, 1].
static HWY_INLINE Interval inside_cone(const V3& q, const V3& v, double cosine) {
    const V k = set(cosine * cosine), zero = hn::Zero(d), infinity = set(std::numeric_limits<double>::infinity());
    const V a = hn::NegMulAdd(k, dot(v, v), hn::Mul(v.z, v.z));
    const V b = hn::NegMulAdd(k, dot(q, v), hn::Mul(q.z, v.z));
    const V c = hn::NegMulAdd(k, dot(q, q), hn::Mul(q.z, q.z));
    const V discriminant = hn::NegMulAdd(a, c, hn::Mul(b, b));
    const V sum = hn::Neg(hn::Add(b, hn::CopySign(hn::Sqrt(hn::Max(discriminant, zero)), b)));
    const auto no_sum = hn::Eq(sum, zero);
    const V root0 = hn::IfThenElse(no_sum, zero, hn::Div(sum, a)),
            root1 = hn::IfThenElse(no_sum, zero, hn::Div(c, sum));
    const V low = hn::Min(root0, root1), high = hn::Max(root0, root1);
    // The ray leaves the double cone on both sides (a < 0): it is inside between the roots, of one of the halves.
    const auto crosses = hn::Lt(a, zero);
    const V middle_z = hn::MulAdd(hn::Mul(set(0.5), hn::Add(low, high)), v.z, q.z);
    const auto is_chord = hn::And(hn::Gt(discriminant, zero), hn::Gt(middle_z, zero));
    // It runs into both halves: beyond the root on the side of +Z.
    const auto forward = hn::Gt(v.z, zero);
    V begin = hn::IfThenElse(crosses, low, hn::IfThenElse(forward, high, hn::Neg(infinity)));
    V end = hn::IfThenElse(crosses, hn::IfThenElse(is_chord, high, low), hn::IfThenElse(forward, infinity, low));
    // It runs along a plane through the light (a half angle of 90 degrees): wholly in front of it or behind.
    const auto is_flat = hn::And(hn::Eq(a, zero), hn::Eq(b, zero));
    const auto in_front = hn::And(hn::Gt(c, zero), hn::Gt(q.z, zero));
    begin = hn::IfThenElse(is_flat, hn::Neg(infinity), begin);
    end = hn::IfThenElse(is_flat, hn::IfThenElse(in_front, infinity, hn::Neg(infinity)), end);
    return {begin, end};
}

/// Where the ray is within the sphere of which the light is a patch; infinite where it misses it.
static HWY_INLINE Interval inside_sphere(const LocalShape& shape, const V3& foot, const V3& along) {
    const V radius = set(shape.sphere_radius_m), middle = hn::Neg(hn::Mul(radius, dot(shape.normal, along)));
    const V3 beside{hn::MulAdd(radius, set(shape.normal.x), foot.x), hn::MulAdd(radius, set(shape.normal.y), foot.y),
                    hn::MulAdd(radius, set(shape.normal.z), foot.z)};
    const V half2 = hn::MulAdd(middle, middle, hn::MulAdd(radius, radius, hn::Neg(dot(beside, beside))));
    const V half = hn::Sqrt(hn::Max(half2, hn::Zero(d))), infinity = set(std::numeric_limits<double>::infinity());
    const auto meets = hn::Gt(half, hn::Zero(d));
    return {hn::IfThenElse(meets, hn::Sub(middle, half), infinity),
            hn::IfThenElse(meets, hn::Add(middle, half), infinity)};
}

/// Keeps what may lie in the lobe of an area light's patch: x^2 + y^2 < tan^2 (z^2 + softening), a hyperboloid. A ray that
/// comes into it twice keeps what lies between. `edge`: a place where the ray crosses it.
static HWY_INLINE void clip_to_spread(const LocalShape& shape, const V3& q, const V3& v, V& begin, V& end, V& edge) {
    const double square = shape.spread_cotangent * shape.spread_cotangent;
    const V k = set(square), zero = hn::Zero(d), infinity = set(std::numeric_limits<double>::infinity());
    const auto across = [&](const V3& p, const V3& r) { return hn::MulAdd(p.x, r.x, hn::Mul(p.y, r.y)); };
    const V a = hn::NegMulAdd(k, across(v, v), hn::Mul(v.z, v.z)),
            b = hn::NegMulAdd(k, across(q, v), hn::Mul(q.z, v.z));
    const V c = hn::Add(hn::NegMulAdd(k, across(q, q), hn::Mul(q.z, q.z)), set(shape.softening_m2));
    const V discriminant = hn::NegMulAdd(a, c, hn::Mul(b, b));
    const V sum = hn::Neg(hn::Add(b, hn::CopySign(hn::Sqrt(hn::Max(discriminant, zero)), b)));
    const auto has_roots = hn::And(hn::Gt(discriminant, zero), hn::Ne(sum, zero));
    const V root0 = hn::IfThenElse(hn::Eq(a, zero), infinity, hn::Div(sum, a)), root1 = hn::Div(c, sum);
    const V low = hn::Min(root0, root1), high = hn::Max(root0, root1);
    const auto is_between = hn::Lt(a, zero); // else it lies in the lobe far along its way, and back
    begin = hn::IfThenElse(hn::And(is_between, has_roots), hn::Max(begin, low), begin);
    end = hn::IfThenElse(is_between, hn::IfThenElse(has_roots, hn::Min(end, high), begin), end);
    const auto rises = hn::Gt(v.z, zero);
    edge = hn::IfThenElse(hn::And(has_roots, hn::Not(is_between)), hn::IfThenElse(rises, high, low), hn::Neg(infinity));
    // Where it comes through the patch's plane beside the lobe, all up to the edge is dark.
    const V at_plane = hn::Neg(hn::Div(q.z, v.z));
    const V3 place{hn::MulAdd(at_plane, v.x, q.x), hn::MulAdd(at_plane, v.y, q.y), zero};
    const auto is_beside = hn::And(hn::Gt(hn::Mul(k, across(place, place)), set(shape.softening_m2)),
                                   hn::And(has_roots, hn::Not(is_between)));
    begin = hn::IfThenElse(hn::And(is_beside, rises), hn::Max(begin, edge), begin);
    end = hn::IfThenElse(hn::And(is_beside, hn::Lt(v.z, zero)), hn::Min(end, edge), end);
}

/// Keeps what lies where at_foot + x per_m is positive.
static HWY_INLINE void clip_to_half_space(V at_foot, V per_m, V& begin, V& end) {
    const V zero = hn::Zero(d), horizon = hn::Neg(hn::Div(at_foot, per_m));
    begin = hn::IfThenElse(hn::Gt(per_m, zero), hn::Max(begin, horizon), begin);
    end = hn::IfThenElse(hn::Lt(per_m, zero), hn::Min(end, horizon), end);
    const auto is_below = hn::And(hn::Eq(per_m, zero), hn::Le(at_foot, zero));
    end = hn::IfThenElse(is_below, begin, end);
}
static HWY_INLINE void clip_to_cell(const LocalShape& shape, const V3& foot, const V3& along, V& begin, V& end) {
    for (std::size_t plane = 0; plane < shape.cell_normals.size(); ++plane)
        if (const dvec3& normal = shape.cell_normals[plane]; normal != dvec3(0.0))
            clip_to_half_space(hn::Add(dot(normal, foot), set(shape.cell_heights[plane])), dot(normal, along), begin,
                               end);
}

void find_support_of(const LocalShape& shape, const LocalRays& rays, LocalSupport& support) {
    const auto keep = [&](LocalSupport::Distance which, std::size_t at, V value) {
        hn::StoreU(value, d, &support.distance[which][at]);
    };
    const auto keep_term = [&](LocalSupport::Term which, std::size_t at, V value) {
        hn::StoreU(hn::DemoteTo(df, value), df, &support.term[which][at]);
    };
    const V infinity = set(std::numeric_limits<double>::infinity());
    for (std::size_t at = 0; at < rays.size(); at += hn::Lanes(d)) {
        const auto in = [&](int column) { return hn::LoadU(d, rays.column(column) + at); };
        const V3 along{in(LocalRays::DirectionX), in(LocalRays::DirectionY), in(LocalRays::DirectionZ)};
        const V3 start{hn::Sub(in(LocalRays::OriginX), set(shape.position.x)),
                       hn::Sub(in(LocalRays::OriginY), set(shape.position.y)),
                       hn::Sub(in(LocalRays::OriginZ), set(shape.position.z))};
        const V light_x = hn::Neg(hn::Div(dot(start, along), dot(along, along)));
        const V3 foot{hn::MulAdd(light_x, along.x, start.x), hn::MulAdd(light_x, along.y, start.y),
                      hn::MulAdd(light_x, along.z, start.z)};
        // Positions are floats: nearer to the line than this, the side of the light is noise.
        const V least = hn::Max(hn::Mul(set(1e-6), hn::Sqrt(dot(start, start))), set(1e-18));
        const V light_y = hn::Max(hn::Sqrt(dot(foot, foot)), least), light_y2 = hn::Mul(light_y, light_y);
        V begin = hn::Sub(in(LocalRays::Near), light_x), end = hn::Sub(in(LocalRays::Far), light_x);
        if (shape.has_cell)
            clip_to_cell(shape, foot, along, begin, end);
        keep(LocalSupport::LightX, at, light_x);
        keep(LocalSupport::LightY, at, light_y);
        keep_term(LocalSupport::LightY2, at, light_y2);
        keep_term(LocalSupport::SoftenedY, at, hn::Sqrt(hn::Add(light_y2, set(shape.softening_m2))));
        if (shape.has_normal) {
            const V at_foot = dot(shape.normal, foot), per_m = dot(shape.normal, along);
            clip_to_half_space(hn::Add(at_foot, set(shape.below_m)), per_m, begin, end);
            keep_term(LocalSupport::NormalD, at, per_m);
            keep(LocalSupport::Normal0, at, at_foot);
            keep(LocalSupport::NormalX, at, per_m);
        }
        if (shape.is_soft) {
            keep_term(LocalSupport::Offset0, at, dot(2.0 * shape.falloff_offset, foot));
            keep_term(LocalSupport::OffsetX, at, dot(2.0 * shape.falloff_offset, along));
        }
        Interval inner{hn::Neg(infinity), infinity};
        if (shape.has_cone) {
            const V3 q = product(shape.cone_from_world, foot), v = product(shape.cone_from_world, along);
            if (shape.is_area) {
                if (shape.spread_cotangent > 0.0)
                    clip_to_spread(shape, q, v, begin, end, inner.end);
                const V along2 = hn::Max(hn::MulAdd(v.x, v.x, hn::Mul(v.y, v.y)), set(1e-30));
                inner.begin = hn::Neg(hn::Div(hn::MulAdd(q.x, v.x, hn::Mul(q.y, v.y)), along2));
            } else if (shape.cos_half >
                       -1e-6) { // more than a half space is not convex: its edge is left to the integration
                const Interval cone = inside_cone(q, v, std::max(shape.cos_half, 0.0));
                begin = hn::Max(begin, cone.begin), end = hn::Min(end, cone.end);
            }
            if (shape.has_soft_edge && shape.cos_inner >= 0.0)
                inner = inside_cone(q, v, shape.cos_inner);
            keep_term(LocalSupport::ConeX, at, q.x), keep_term(LocalSupport::ConeDx, at, v.x);
            keep_term(LocalSupport::ConeY, at, q.y), keep_term(LocalSupport::ConeDy, at, v.y);
            keep_term(LocalSupport::ConeZ, at, q.z), keep_term(LocalSupport::ConeDz, at, v.z);
        }
        keep(LocalSupport::Begin, at, begin), keep(LocalSupport::End, at, end);
        keep(LocalSupport::Inner0, at, inner.begin), keep(LocalSupport::Inner1, at, inner.end);
        if (shape.sphere_radius_m > 0.0) {
            const Interval body = inside_sphere(shape, foot, along);
            keep(LocalSupport::Body0, at, body.begin), keep(LocalSupport::Body1, at, body.end);
        }
    }
}
} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::light_shafts {
LocalShape::LocalShape(const LightSample& light)
    : position(light.position), has_normal(light.emission_normal != vec3(0.0f)), is_soft(light.softening_m2 > 0.0f),
      faces_receivers(light.faces_receivers), has_cone(light.spot != nullptr), has_soft_edge(false),
      keeps_cosine(false), is_area(has_cone && light.spot->kind == LightKind::Area), normal(light.emission_normal),
      falloff_offset(light.falloff_offset), softening_m2(light.softening_m2), sphere_radius_m(light.sphere_radius_m),
      has_cell(light.cell != nullptr) {
    for (std::size_t plane = 0; has_cell && plane < cell_normals.size(); ++plane) {
        cell_normals[plane] = dvec3(light.cell->inwards[plane]);
        cell_heights[plane] = glm::dot(cell_normals[plane], position - dvec3(light.cell->apex));
    }
    if (sphere_radius_m > 0.0) {
        const double softening_m = std::sqrt(softening_m2);
        below_m = sphere_radius_m * softening_m / (sphere_radius_m + softening_m);
    }
    if (!has_cone)
        return;
    const Light& spot = *light.spot;
    if (is_area) {
        const AreaSpread spread = area_spread(spot);
        spread_cotangent = double{spread.cotangent};
        cos_half = spread_cotangent / std::hypot(spread_cotangent, 1.0);
        const mat3 axes = light_axes(spot);
        cone_from_world = glm::transpose(glm::dmat3(dvec3(axes[0]), dvec3(axes[1]), dvec3(spot.spot_axis)));
        const vec2 place(cone_from_world * (position - dvec3(spot.position)));
        outline = area_outline(spot);
        for (std::size_t corner = 2; corner < outline.count; ++corner) {
            const vec2 a = outline.corners_m[corner - 1] - outline.corners_m[0];
            const vec2 b = outline.corners_m[corner] - outline.corners_m[0];
            twice_fan_m2[corner - 2] = a.x * b.y - a.y * b.x;
        }
        for (vec2& corner : outline.corners_m)
            corner -= place;
        edge_width = tyndall::edge_width(spread);
        return;
    }
    cos_half = std::cos(double{spot.spot_half_angle_rad});
    const double sine = std::sin(0.5 * double{spot.spot_half_angle_rad});
    one_minus_cos_half = 2.0 * sine * sine; // exact in a narrow cone, too
    const double smooth = one_minus_cos_half * spot.spot_blend;
    cos_inner = cos_half + smooth;
    has_soft_edge = smooth > 0.0;
    per_smooth = has_soft_edge ? 1.0 / smooth : 0.0;
    keeps_cosine = spot.spot_falloff == SpotFalloff::Blender3;
    if (keeps_cosine) {
        const auto [u, v] = orthonormal_basis(spot.spot_axis);
        cone_from_world = glm::transpose(glm::dmat3(dvec3(u), dvec3(v), dvec3(spot.spot_axis)));
    } else {
        cone_from_world = glm::dmat3(dvec3(1, 0, 0), dvec3(0, 1, 0), dvec3(0, 0, -1)) *
                          glm::dmat3(spot.light_from_world_directions); // shines along -Z
    }
}

void LocalSupport::resize(std::size_t ray_count) {
    const std::size_t padded = (ray_count + LocalRays::padding - 1) / LocalRays::padding * LocalRays::padding;
    if (distance[0].size() >= padded)
        return;
    for (std::vector<double>& values : distance)
        values.resize(padded);
    for (std::vector<float>& values : term)
        values.resize(padded);
}

HWY_EXPORT(find_support_of);
void find_support(const LocalShape& shape, const LocalRays& rays, LocalSupport& support) {
    support.resize(rays.size());
    HWY_DYNAMIC_DISPATCH(find_support_of)(shape, rays, support);
}
} // namespace tyndall::light_shafts
#endif
