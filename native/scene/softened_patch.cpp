// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/softened_patch.hpp"
#include "scene/light_axes.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tyndall {
/// Corners of the outline of half sizes of 1.
static std::array<vec2, 8> unit_corners(std::size_t count) {
    std::array<vec2, 8> corners{};
    const double reach = count == 8 ? std::sqrt(std::numbers::pi / std::sqrt(8.0)) : std::sqrt(2.0);
    for (std::size_t corner = 0; corner < count; ++corner) {
        const double turn = (2.0 * static_cast<double>(corner) + 1.0) / static_cast<double>(count) * std::numbers::pi;
        corners[corner] = vec2(reach * dvec2(std::cos(turn), std::sin(turn)));
    }
    return corners;
}

AreaOutline area_outline(const Light& light) {
    static const std::array<vec2, 8> square = unit_corners(4), octagon = unit_corners(8);
    AreaOutline outline{light.is_ellipse ? octagon : square, light.is_ellipse ? 8u : 4u};
    for (vec2& corner : outline.corners_m)
        corner *= light.half_size_m;
    return outline;
}

double half_solid_angle_sr(const AreaOutline& outline, const dvec2& foot_m, double height_m) {
    const auto towards = [&](std::size_t corner) {
        return glm::normalize(dvec3(dvec2(outline.corners_m[corner]) - foot_m, height_m));
    };
    const dvec3 first = towards(0);
    dvec3 last = towards(1);
    dvec2 product(1.0, 0.0);
    for (std::size_t corner = 2; corner < outline.count; ++corner) { // eq. 8
        const dvec3 next = towards(corner);
        const double real = 1.0 + glm::dot(first, last) + glm::dot(last, next) + glm::dot(next, first);
        const double imaginary = glm::dot(first, glm::cross(last, next));
        product = {product.x * real - product.y * imaginary, product.x * imaginary + product.y * real};
        last = next;
    }
    return std::atan2(std::max(product.y, 0.0), product.x); // of triangles on one side: at most half a turn
}

static bool is_area_patch(const LightSample& sample) {
    return sample.softening_m2 > 0.0f && sample.spot != nullptr && sample.spot->kind == LightKind::Area;
}
static bool is_sphere_patch(const LightSample& sample) {
    return sample.softening_m2 > 0.0f && sample.sphere_radius_m > 0.0f;
}

namespace {
/// A patch from a point that lies `before_m` before the lamp, as from one that lies `softened_m` before it.
struct Lift {
    dvec3 axis; ///< Unit vector off the lamp.
    double before_m, softened_m;

    Lift(const LightSample& patch, const dvec3& way) : axis(patch.emission_normal) {
        double height_m = glm::dot(way, axis);
        if (!is_area_patch(patch)) {
            const dvec3 from_middle = way + double{patch.sphere_radius_m} * axis;
            const double middle_m = glm::length(from_middle);
            axis = from_middle / middle_m, height_m = middle_m - double{patch.sphere_radius_m};
        }
        before_m = std::max(height_m, 0.0);
        softened_m = std::sqrt(before_m * before_m + double{patch.softening_m2});
        is_inside = height_m < 0.0;
    }
    /// Of the solid angles in which both points see the whole lamp.
    [[nodiscard]] double share_of_angles(const LightSample& patch, const dvec3& point) const {
        const double far = before_m * before_m / (far_before_softenings * double{patch.softening_m2});
        const double fade = std::clamp(2.0 - far, 0.0, 1.0);
        if (!is_area_patch(patch))
            return is_inside ? 0.0 : std::lerp(1.0, cap(patch, before_m) / cap(patch, softened_m), fade);
        if (fade == 0.0)
            return 1.0;
        const Light& light = *patch.spot;
        const dvec3 from_middle = point - dvec3(light.position);
        const mat3 axes = light_axes(light);
        const dvec2 foot(glm::dot(from_middle, dvec3(axes[0])), glm::dot(from_middle, dvec3(axes[1])));
        const AreaOutline outline = area_outline(light);
        const double width = edge_width(area_spread(light));
        return std::lerp(1.0,
                         half_solid_angle_sr(outline, foot, width * before_m) /
                             half_solid_angle_sr(outline, foot, width * softened_m),
                         fade);
    }
    [[nodiscard]] dvec3 lifted(const dvec3& way) const { return way + (softened_m - before_m) * axis; }
    [[nodiscard]] double distance_m(double lifted_m) const {
        return lifted_m - (softened_m - before_m) * std::sqrt(lifted_m / softened_m);
    }

private:
    static double cap(const LightSample& patch, double height_m) {
        const double sine = patch.sphere_radius_m / (patch.sphere_radius_m + height_m), sine2 = sine * sine;
        return sine2 / (1.0 + std::sqrt(1.0 - sine2));
    }
    bool is_inside; ///< A sphere, of which this is what shines outwards.
};
} // namespace

float local_distance_m(const LightSample& sample, const vec3& point) {
    const dvec3 way = dvec3(point) - dvec3(sample.position);
    if (!is_area_patch(sample) && !is_sphere_patch(sample))
        return static_cast<float>(glm::length(way));
    const Lift lift(sample, way);
    return static_cast<float>(lift.distance_m(glm::length(lift.lifted(way))));
}

LocalView view_local(const LightSample& sample, const vec3& point) {
    const dvec3 way = dvec3(point) - dvec3(sample.position);
    const vec3 straight(glm::normalize(way));
    const bool is_area = is_area_patch(sample);
    if (!is_area && !is_sphere_patch(sample))
        return {straight, static_cast<float>(glm::length(way)),
                intensity_w_per_sr(sample, straight) * irradiance_per_intensity(sample, point)};
    const Lift lift(sample, way);
    const dvec3 lifted = lift.lifted(way), beside = way - glm::dot(way, lift.axis) * lift.axis;
    const double lifted_m = glm::length(lifted), z = glm::dot(lifted, lift.axis) / lifted_m;
    const double share = lift.share_of_angles(sample, dvec3(point));
    const double off = std::clamp(share > 1.0 ? 1.0 - (1.0 - z) * share : z * share, 0.0, 1.0);
    const dvec3 aside = std::sqrt(1.0 - off * off) / std::max(glm::length(beside), 1e-10) * beside;
    const vec3 shaping(lifted / lifted_m);
    Rgb intensity = sample.strength;
    if (is_area)
        intensity = intensity_w_per_sr(sample, shaping);
    else // the cone of a spot light is where it is
        intensity *= std::max(0.0f, glm::dot(sample.emission_normal, shaping)) *
                     (sample.spot != nullptr ? spot_attenuation(*sample.spot, straight) : 1.0f);
    return {vec3(off * lift.axis + aside), static_cast<float>(lift.distance_m(lifted_m)),
            intensity * static_cast<float>(share / (lifted_m * lifted_m))};
}
} // namespace tyndall
