// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/softened_patch.hpp"
#include "scene/light_axes.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tyndall {
AreaOutline area_outline(const Light& light) {
    AreaOutline outline{{}, light.is_ellipse ? 8u : 4u};
    const double reach = light.is_ellipse ? std::sqrt(std::numbers::pi / std::sqrt(8.0)) : std::sqrt(2.0);
    for (std::size_t corner = 0; corner < outline.count; ++corner) {
        const double turn =
            (2.0 * static_cast<double>(corner) + 1.0) / static_cast<double>(outline.count) * std::numbers::pi;
        outline.corners_m[corner] = vec2(reach * dvec2(std::cos(turn), std::sin(turn))) * light.half_size_m;
    }
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

namespace {
/// A patch from a point that lies `before_m` before the lamp, as from one that lies `softened_m` before it.
struct Lift {
    dvec3 axis; ///< Unit vector off the lamp.
    double before_m, softened_m;
    double share = 1.0; ///< Of the solid angles in which both points see the whole lamp.

    Lift(const dvec3& off_lamp, double height_m, double softening_m2)
        : axis(off_lamp), before_m(std::max(height_m, 0.0)), softened_m(std::sqrt(before_m * before_m + softening_m2)),
          fade_(std::clamp(2.0 - before_m * before_m / (far_before_softenings * softening_m2), 0.0, 1.0)) {}
    void share_angles(double seen, double softly_seen) { share = std::lerp(1.0, seen / softly_seen, fade_); }
    [[nodiscard]] bool is_far() const { return fade_ == 0.0; }

private:
    double fade_;
};

Lift lift_off_area(const LightSample& patch, const dvec3& point) {
    const Light& light = *patch.spot;
    const dvec3 axis(patch.emission_normal), from_middle = point - dvec3(light.position);
    Lift lift(axis, glm::dot(from_middle, axis), double{patch.softening_m2});
    if (lift.is_far())
        return lift;
    const mat3 axes = light_axes(light);
    const dvec2 foot(glm::dot(from_middle, dvec3(axes[0])), glm::dot(from_middle, dvec3(axes[1])));
    const AreaOutline outline = area_outline(light);
    const double width = edge_width(area_spread(light));
    lift.share_angles(half_solid_angle_sr(outline, foot, width * lift.before_m),
                      half_solid_angle_sr(outline, foot, width * lift.softened_m));
    return lift;
}

Lift lift_off_sphere(const LightSample& patch, const dvec3& point) {
    const double radius_m = patch.sphere_radius_m;
    const dvec3 from_middle = point - dvec3(patch.position) + radius_m * dvec3(patch.emission_normal);
    const double middle_m = glm::length(from_middle);
    Lift lift(from_middle / middle_m, middle_m - radius_m, double{patch.softening_m2});
    const auto cap = [&](double height_m) {
        const double sine = radius_m / (radius_m + height_m), sine2 = sine * sine;
        return sine2 / (1.0 + std::sqrt(1.0 - sine2));
    };
    lift.share_angles(cap(lift.before_m), cap(lift.softened_m));
    if (middle_m < radius_m)
        lift.share = 0.0; // of what shines outwards
    return lift;
}
} // namespace

LocalView view_local(const LightSample& sample, const vec3& point) {
    const dvec3 way = dvec3(point) - dvec3(sample.position);
    const vec3 straight(glm::normalize(way));
    const bool is_area = sample.spot != nullptr && sample.spot->kind == LightKind::Area;
    if (sample.softening_m2 == 0.0f || !(is_area || sample.sphere_radius_m > 0.0f))
        return {straight, static_cast<float>(glm::length(way)),
                intensity_w_per_sr(sample, straight) * irradiance_per_intensity(sample, point)};
    const Lift lift = is_area ? lift_off_area(sample, dvec3(point)) : lift_off_sphere(sample, dvec3(point));
    const double nearer_m = lift.softened_m - lift.before_m;
    const dvec3 lifted = way + nearer_m * lift.axis, beside = way - glm::dot(way, lift.axis) * lift.axis;
    const double lifted_m = glm::length(lifted), z = glm::dot(lifted, lift.axis) / lifted_m;
    const double off = std::clamp(lift.share > 1.0 ? 1.0 - (1.0 - z) * lift.share : z * lift.share, 0.0, 1.0);
    const dvec3 aside = std::sqrt(1.0 - off * off) / std::max(glm::length(beside), 1e-10) * beside;
    Rgb intensity = intensity_w_per_sr(sample, vec3(lifted / lifted_m));
    if (!is_area && sample.spot != nullptr) { // a cone is where it is
        const float lobe = std::max(0.0f, glm::dot(sample.emission_normal, vec3(lifted / lifted_m)));
        intensity = sample.strength * (lobe * spot_attenuation(*sample.spot, straight));
    }
    return {vec3(off * lift.axis + aside),
            static_cast<float>(lifted_m - nearer_m * std::sqrt(lifted_m / lift.softened_m)),
            intensity * static_cast<float>(lift.share / (lifted_m * lifted_m))};
}
} // namespace tyndall
