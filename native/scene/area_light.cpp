// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/area_light.hpp"
#include "core/sampling.hpp"
#include "scene/light_axes.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tyndall {
/// A quarter turn less this is none: its slats hold back nothing that counts.
static constexpr float no_slats_rad = 1e-5f;
/// Cycles 4 lets a spread be 0, a beam of parallel light; here its edge then blurs by 1 mm per metre.
static constexpr double least_half_spread_rad = 1e-3;

bool is_narrow_area(const Light& light) {
    return light.kind == LightKind::Area && light.spot_half_angle_rad < 0.5f * std::numbers::pi_v<float> - no_slats_rad;
}

AreaSpread area_spread(const Light& light) {
    if (!is_narrow_area(light))
        return {};
    const double half_rad = std::max(double{light.spot_half_angle_rad}, least_half_spread_rad);
    const double cotangent = 1.0 / std::tan(half_rad);
    // Twice the integral of (cos t - cotangent sin t) sin t over [0, half_rad], as a series where it cancels.
    const double square = half_rad * half_rad;
    const double passing = half_rad < 0.05 ? square * (1.0 / 3.0 + square / 45.0) : 1.0 - half_rad * cotangent;
    return {static_cast<float>(1.0 / passing), static_cast<float>(cotangent)};
}

float area_m2(const Light& light) {
    return (light.is_ellipse ? std::numbers::pi_v<float> : 4.0f) * light.half_size_m.x * light.half_size_m.y;
}

vec3 area_point(const Light& light, vec2 u) {
    const mat3 axes = light_axes(light);
    const vec2 place = (light.is_ellipse ? sample_concentric_disc(u) : 2.0f * u - 1.0f) * light.half_size_m;
    return light.position + place.x * axes[0] + place.y * axes[1];
}

/// Solid angle of the corner region between the point's foot and (x, y).
static double corner_angle_sr(double x, double y, double height) {
    return std::atan2(x * y, height * std::sqrt(x * x + y * y + height * height));
}

double rectangle_solid_angle_sr(const dvec2& low, const dvec2& high, double height) {
    const double from = corner_angle_sr(low.x, high.y, height) - corner_angle_sr(low.x, low.y, height);
    return corner_angle_sr(high.x, high.y, height) - corner_angle_sr(high.x, low.y, height) - from;
}

namespace {
/// A rectangle as seen from a point: its plane lies at z = height.
struct SeenRectangle {
    dvec2 low, high;
    double height;

    /// [Urena 2013] fig. 3: b_0 and b_1 are here those of the lower and of the upper edge.
    [[nodiscard]] dvec2 sample(vec2 u, double& solid_angle) const {
        const double from = corner_angle_sr(low.x, high.y, height) - corner_angle_sr(low.x, low.y, height);
        solid_angle = rectangle_solid_angle_sr(low, high, height);
        if (solid_angle < least_solid_angle_sr)
            return glm::mix(low, high, dvec2(u));
        const double turn = from + double{u.x} * solid_angle;
        const double lower = -low.y / std::hypot(low.y, height), upper = high.y / std::hypot(high.y, height);
        const double sine = -std::sin(turn), f = -std::cos(turn) * lower - upper;
        const double cosine = std::copysign(1.0, f) * sine / std::sqrt(f * f + lower * lower * sine * sine);
        const double x = std::clamp(cosine * height / std::sqrt(std::max(1e-30, 1.0 - cosine * cosine)), low.x, high.x);
        const double across2 = x * x + height * height;
        const double h0 = low.y / std::sqrt(across2 + low.y * low.y),
                     h1 = high.y / std::sqrt(across2 + high.y * high.y);
        const double h = std::lerp(h0, h1, double{u.y});
        const double y = h * std::sqrt(across2 / std::max(1e-30, 1.0 - h * h));
        return {x, std::clamp(y, low.y, high.y)};
    }
};
} // namespace

AreaPoint area_point_towards(const Light& light, vec2 u, const vec3& receiver) {
    AreaPoint result{light.position, 0.0f};
    const mat3 axes = light_axes(light);
    const dvec3 way(receiver - light.position);
    const double height = glm::dot(way, dvec3(light.spot_axis));
    if (!(height > 0.0))
        return result;
    const dvec2 foot(glm::dot(way, dvec3(axes[0])), glm::dot(way, dvec3(axes[1]))), half(light.half_size_m);
    const AreaSpread spread = area_spread(light);
    const dvec2 reach(spread.cotangent > 0.0f ? height / double{spread.cotangent} : INFINITY);
    const SeenRectangle seen{glm::max(-half - foot, -reach), glm::min(half - foot, reach), height};
    if (!(seen.low.x < seen.high.x && seen.low.y < seen.high.y))
        return result;
    const double area = area_m2(light);
    const dvec2 away = glm::max(glm::abs(foot) - half, dvec2(0.0)), across = glm::abs(foot) + half;
    const double nearest2 = glm::dot(away, away) + height * height,
                 farthest2 = glm::dot(across, across) + height * height;
    const dvec2 size = seen.high - seen.low;
    const bool is_whole = size.x > 1.9999 * half.x && size.y > 1.9999 * half.y;
    dvec2 place;
    double share;
    if (light.is_ellipse && is_whole && farthest2 < double{area_far_ratio} * nearest2) {
        place = dvec2(sample_concentric_disc(u)) * half - foot;
        share = 1.0;
    } else {
        double solid_angle = 0.0;
        place = seen.sample(u, solid_angle);
        const double distance2 = glm::dot(place, place) + height * height;
        share = (solid_angle < least_solid_angle_sr ? size.x * size.y
                                                    : solid_angle * distance2 * std::sqrt(distance2) / height) /
                area;
        const dvec2 on_unit = (place + foot) / half;
        if (light.is_ellipse && glm::dot(on_unit, on_unit) > 1.0)
            share = 0.0;
    }
    result.position += vec3((place.x + foot.x) * dvec3(axes[0]) + (place.y + foot.y) * dvec3(axes[1]));
    result.share = spread.gain * static_cast<float>(share);
    return result;
}
} // namespace tyndall
