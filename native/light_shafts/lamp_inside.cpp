// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/lamp_inside.hpp"
#include "core/sampling.hpp"
#include "light_shafts/scatter_pieces.hpp"
#include <cmath>

namespace tyndall::light_shafts {
LampInside::LampInside(const Light& light, bool is_dimmed)
    : centre_(light.position), radius_m_(light.radius_m),
      radiance_(light.strength / (pi * light.radius_m * light.radius_m)), is_dimmed_(is_dimmed) {}

void LampInside::aim_within(const Light& light, const vec3& point, vec2 u, LightSample& sample) {
    const vec3 way = light.position - point;
    const float within2 = light.radius_m * light.radius_m - glm::dot(way, way);
    if (!(within2 >= 0.0f))
        return;
    const vec3 direction = sample_uniform_sphere(u);
    const float middle_m = glm::dot(way, direction), far_m = middle_m + std::sqrt(middle_m * middle_m + within2);
    sample.position = point + far_m * direction;
    sample.strength = light.strength * (4.0f * far_m * far_m / (light.radius_m * light.radius_m));
}

Rgb LampInside::along(const Media& media, const ViewRay& ray, std::span<const MediumSegment> segments) const {
    const vec3 way = centre_ - ray.origin;
    const float middle_m = glm::dot(way, ray.direction);
    const vec3 beside = way - middle_m * ray.direction;
    const float half2 = radius_m_ * radius_m_ - glm::dot(beside, beside);
    if (!(half2 > 0.0f))
        return Rgb(0.0f);
    const float near_m = std::max(ray.near_m, middle_m - std::sqrt(half2)),
                far_m = std::min(ray.far_m, middle_m + std::sqrt(half2));
    Rgb sum(0.0f), depth(0.0f);
    for (const MediumSegment& segment : segments) {
        if (segment.near_m >= far_m)
            break;
        const Rgb sigma_t = media.sigma_t_per_m(segment.set);
        const float begin_m = std::max(segment.near_m, near_m), end_m = std::min(segment.far_m, far_m);
        if (begin_m < end_m) {
            // From a point to the sphere it is one radius in the centre, and half of that on the sphere, in the mean.
            const vec3 from_centre = beside + (middle_m - 0.5f * (begin_m + end_m)) * ray.direction;
            const float mean_m = radius_m_ - 0.5f * glm::dot(from_centre, from_centre) / radius_m_;
            const ScatterPiece piece{.near_m = segment.near_m,
                                     .far_m = segment.far_m,
                                     .source_per_m = media.sigma_s_per_m(segment.set) * radiance_,
                                     .depth_at_near = depth + (is_dimmed_ ? sigma_t * mean_m : Rgb(0.0f)),
                                     .depth_per_m = sigma_t};
            sum += scattered(piece, begin_m, end_m);
        }
        depth += sigma_t * (std::min(segment.far_m, far_m) - segment.near_m);
    }
    return sum;
}
} // namespace tyndall::light_shafts
