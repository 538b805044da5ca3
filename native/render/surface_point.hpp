// SPDX-License-Identifier: GPL-3.0-or-later
// A surface point that a view ray found, with what every light asks of it, worked out once.
#pragma once
#include "core/random.hpp"
#include "scene/scene.hpp"
#include "scene/strand_surface.hpp"

namespace tyndall::render {
struct SurfacePoint {
    Hit hit;
    ShadingPoint shading;
    SpawnPoint spawn;
    bool is_smooth;             ///< Has normals of its own: shadow rays may have to be lifted.
    std::uint32_t pixel_seed;   ///< Of the pixel whose random numbers it takes.
    std::uint32_t passed_count; ///< Transparent surfaces on the way here: those that it sends out count on from there.
    float lambert_share =
        1.0f; ///< Of light, that Lambert's part of it sends back: beside it lobes have their directions.

    /// Whatever the shading normal says.
    [[nodiscard]] bool is_below_surface(const vec3& direction) const {
        return (glm::dot(direction, shading.geometric_normal) > 0.0f) == shading.is_backface;
    }
    [[nodiscard]] Ray ray_towards(const vec3& direction) const {
        return {.origin = spawn.towards(direction), .direction = direction, .passed_count = passed_count};
    }
};
[[nodiscard]] inline SurfacePoint surface_point(const Scene& scene, const Ray& ray, const Hit& hit,
                                                std::uint32_t pixel_seed) {
    const ShadingPoint shading = scene.shading_point(ray, hit);
    return {.hit = hit,
            .shading = shading,
            .spawn = scene.spawn_point(ray, hit, shading),
            .is_smooth = scene.is_smooth(hit.instance) && !scene.is_cube(hit), // from a cube they leave outside of it
            .pixel_seed = pixel_seed,
            .passed_count = ray.passed_count};
}
/// The point as light from behind meets it, with random numbers of its own.
[[nodiscard]] inline SurfacePoint other_side(const Scene& scene, SurfacePoint point) {
    point.spawn = other_side_spawn_point(scene, point.hit, point.spawn);
    point.shading.shading_normal = -point.shading.shading_normal;
    point.shading.is_backface = !point.shading.is_backface;
    point.pixel_seed = hash(point.pixel_seed, 1);
    return point;
}
} // namespace tyndall::render
