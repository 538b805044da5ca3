// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/area_patch.hpp"
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

static double edge_share_of(const LightSample& sample, const dvec3& point, double before_m, double softened_m) {
    const double far = before_m * before_m / (far_before_softenings * double{sample.softening_m2});
    if (far >= 2.0)
        return 1.0;
    const Light& light = *sample.spot;
    const mat3 axes = light_axes(light);
    const dvec3 way = point - dvec3(light.position);
    const dvec2 foot(glm::dot(way, dvec3(axes[0])), glm::dot(way, dvec3(axes[1])));
    const AreaOutline outline = area_outline(light);
    const double width = edge_width(area_spread(light));
    const double share =
        half_solid_angle_sr(outline, foot, width * before_m) / half_solid_angle_sr(outline, foot, width * softened_m);
    return std::lerp(1.0, share, std::min(2.0 - far, 1.0));
}

LocalView view_local(const LightSample& sample, const vec3& point) {
    const dvec3 way = dvec3(point) - dvec3(sample.position);
    if (sample.softening_m2 == 0.0f || sample.spot == nullptr || sample.spot->kind != LightKind::Area) {
        const vec3 from_light(glm::normalize(way));
        return {from_light, from_light, static_cast<float>(glm::length(way))};
    }
    const dvec3 axis(sample.emission_normal);
    const double before_m = std::max(glm::dot(way, axis), 0.0);
    const double softened_m = std::sqrt(before_m * before_m + double{sample.softening_m2}),
                 nearer_m = softened_m - before_m;
    const dvec3 softened_way = way + nearer_m * axis, beside = way - glm::dot(way, axis) * axis;
    const double way_m = glm::length(softened_way), z = softened_m / way_m;
    const double edges = edge_share_of(sample, dvec3(point), before_m, softened_m);
    // Light comes from all of the whole light's directions, of which the solid angles tell how far aside they reach.
    const double down = std::clamp(edges > 1.0 ? 1.0 - (1.0 - z) * edges : z * edges, 0.0, 1.0);
    const dvec3 aside = std::sqrt(1.0 - down * down) / std::max(glm::length(beside), 1e-10) * beside;
    return {vec3(softened_way / way_m), vec3(down * axis + aside),
            static_cast<float>(way_m - nearer_m * std::sqrt(way_m / softened_m)), static_cast<float>(edges)};
}
} // namespace tyndall
