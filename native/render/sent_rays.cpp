// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/sent_rays.hpp"
#include "core/sobol.hpp"
#include "scene/strand_surface.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall::render {
// Of what a ray counts; above, it is followed always.
static constexpr float least_split = 1.0f / 16.0f;

/// On the side that the ray comes from.
static vec3 outside_of(const ShadingPoint& point) {
    return point.is_backface ? -point.geometric_normal : point.geometric_normal;
}

Ray mirrored_ray(const SurfacePoint& point, const Ray& ray, const vec3& normal) {
    const vec3 outside = outside_of(point.shading);
    vec3 direction = glm::reflect(ray.direction, normal);
    if (glm::dot(direction, outside) <= 0.0f) // a normal of its own may turn it into the surface
        direction = glm::reflect(ray.direction, outside);
    direction = glm::normalize(direction);
    return {.origin = point.spawn.towards(direction), .direction = direction};
}

/// In doubles: a ray that an index of 1 does not bend is to stay on its way.
static std::optional<vec3> refracted(const dvec3& direction, const dvec3& normal, double ior) {
    const double cosine = -glm::dot(direction, normal), ratio = 1.0 / ior;
    const double inner2 = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    if (!(inner2 > 0.0))
        return std::nullopt;
    return vec3(glm::normalize(ratio * direction + (ratio * cosine - std::sqrt(inner2)) * normal));
}

std::optional<Ray> bent_ray(const Scene& scene, const SurfacePoint& point, const Ray& ray, const vec3& normal,
                            float ior) {
    const vec3 outside = outside_of(point.shading);
    std::optional<vec3> direction = refracted(dvec3(ray.direction), dvec3(normal), double{ior});
    if (direction && glm::dot(*direction, outside) >= 0.0f)
        direction = refracted(dvec3(ray.direction), dvec3(outside), double{ior});
    if (!direction || glm::dot(*direction, outside) >= 0.0f)
        return std::nullopt;
    return Ray{.origin = other_side_spawn_point(scene, point.hit, point.spawn).towards(*direction),
               .direction = *direction};
}

float gain_of(const SurfaceClosures& closures, std::span<const Lobe> bent) {
    constexpr float rounding = 1e-4f; // of many surfaces in a row it makes no more than a few times as many rays
    Rgb sum = closures.transparent + closures.mirrored;
    for (const Lobe& lobe : bent)
        sum += lobe.a + lobe.weight;
    const float gain = std::max({sum.x, sum.y, sum.z});
    return gain > 1.0f + rounding ? gain : 1.0f;
}

Rgb DrawnWays::followed(const Rgb& share) {
    const Rgb weights = in_front_ * share;
    const float weight = std::max({weights.x, weights.y, weights.z});
    if (weight >= least_split)
        return share;
    if (!(weight > 1e-9f))
        return Rgb(0.0f);
    if (!number_)
        number_ = sobol_point(sample_index_, seed_).x;
    const float before = std::floor(drawn_ + *number_);
    drawn_ += weight / least_split;
    return std::floor(drawn_ + *number_) > before ? share * (least_split / weight) : Rgb(0.0f);
}
} // namespace tyndall::render
