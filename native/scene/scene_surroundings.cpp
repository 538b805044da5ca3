// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/scene_surroundings.hpp"
#include "core/sobol.hpp"

namespace tyndall {
vec2 SceneSurroundings::pair(std::uint32_t index, std::uint32_t count, std::uint32_t purpose) const {
    return sobol_point(asking_.random->sample_index * count + index, hash(asking_.random->seed, purpose));
}

vec2 SceneSurroundings::own_pair(std::uint32_t index, std::uint32_t purpose) const {
    return sobol_point(index, hash(asking_.random->seed, purpose, asking_.random->sample_index));
}

std::size_t SceneSurroundings::open_count(std::span<const vec3> directions, float reach_m, Among among) const {
    const SpawnPoint spawn = scene_.spawn_point(asking_.ray, hit_, point_);
    thread_local std::vector<Ray> rays;
    rays.clear();
    for (const vec3& direction : directions)
        rays.push_back({.origin = spawn.towards(direction), .direction = direction, .near_m = 0.0f, .far_m = reach_m});
    return among == Among::OwnObject ? scene_.open_count(rays, hit_.instance) : scene_.open_count(rays);
}

void SceneSurroundings::meet_own(const vec3& origin, const vec3& unit_direction, float reach_m,
                                 std::vector<OwnSurface>& met) const {
    const Ray ray{.origin = origin, .direction = unit_direction, .near_m = 0.0f, .far_m = reach_m};
    thread_local std::vector<Hit> hits;
    hits.clear();
    scene_.append_hits(ray, hit_.instance, hits);
    for (const Hit& hit : hits) {
        const ShadingPoint there = scene_.shading_point(ray, hit);
        met.push_back({.position = there.position,
                       .geometric_normal = there.geometric_normal,
                       .shading_normal = there.is_backface ? -there.shading_normal : there.shading_normal});
    }
}
} // namespace tyndall
