// SPDX-License-Identifier: GPL-3.0-or-later
// EXACT is the truth of all other shaft tests, so it is held against rays: at random points of random view rays it must
// say what Embree says, whatever the occluders, the light, the transform.
#include "light_shafts/exact_strip.hpp"
#include "support/soup.hpp"
#include <doctest/doctest.h>

using namespace tyndall;
using namespace tyndall::light_shafts;

namespace {
LightSample sun(const vec3& towards_light) {
    return {.is_directional = true, .towards_light = glm::normalize(towards_light)};
}
LightSample lamp(const vec3& position) { return {.is_directional = false, .position = position}; }

LitRows lit_rows(const Scene& scene, const LightSample& light, std::span<const ViewRay> rays) {
    Progress progress;
    LitRows rows;
    make_exact_strip(scene, {}, light, rays, {}, progress)->lit_intervals(rays, rows);
    return rows;
}

Rgb transmittance_at(std::span<const LitInterval> intervals, float t) {
    for (const LitInterval& lit : intervals)
        if (lit.near_m <= t && t < lit.far_m)
            return lit.transmittance;
    return Rgb(0.0f);
}
/// Distance along the ray to the nearest end of an interval.
float distance_to_end(std::span<const LitInterval> intervals, float t) {
    float least = std::numeric_limits<float>::infinity();
    for (const LitInterval& lit : intervals)
        least = std::min({least, std::abs(lit.near_m - t), std::abs(lit.far_m - t)});
    return least;
}

/// One shadow ray, which knows nothing of strips.
Rgb shadow_ray(const Scene& scene, const LightSample& light, const vec3& point) {
    if (light.is_directional)
        return scene.shadow_transmittance({.origin = point, .direction = light.towards_light});
    const vec3 way = light.position - point;
    const float distance_m = glm::length(way);
    return scene.shadow_transmittance({.origin = point, .direction = way / distance_m, .far_m = distance_m});
}

struct Agreement {
    int wrong = 0, told = 0, lit = 0, transitions = 0;
};
/// Asks both at random points. Points closer to a shadow's edge than float32 can tell are left out; `tolerance_m` is
/// that distance across the light, which along the ray grows with 1 / sine.
Agreement agreement(const Scene& scene, const LightSample& light, std::span<const ViewRay> rays, float tolerance_m,
                    std::uint64_t seed) {
    const LitRows rows = lit_rows(scene, light, rays);
    support::SceneRandom random(seed);
    Agreement result;
    for (std::size_t ray = 0; ray < rays.size(); ++ray) {
        const auto intervals =
            std::span(rows.intervals).subspan(rows.first[ray], rows.first[ray + 1] - rows.first[ray]);
        result.transitions += static_cast<int>(intervals.size());
        for (int sample = 0; sample < 32; ++sample) {
            const float t = random.uniform(rays[ray].near_m, rays[ray].far_m);
            const vec3 point = rays[ray].origin + t * rays[ray].direction;
            const vec3 way = light.is_directional ? light.towards_light : glm::normalize(light.position - point);
            const float sine = glm::length(glm::cross(way, rays[ray].direction));
            if (distance_to_end(intervals, t) * sine < tolerance_m)
                continue;
            const Rgb truth = shadow_ray(scene, light, point), ours = transmittance_at(intervals, t);
            ++result.told;
            result.lit += truth != Rgb(0.0f);
            result.wrong += glm::any(glm::greaterThan(glm::abs(truth - ours), Rgb(1e-6f)));
        }
    }
    return result;
}

std::vector<ViewRay> random_rays(std::size_t count, float reach_m, std::uint64_t seed) {
    support::SceneRandom random(seed);
    std::vector<ViewRay> rays;
    for (std::size_t ray = 0; ray < count; ++ray) {
        const float near_m = random.uniform(0.0f, 2.0f);
        const vec3 origin = reach_m * vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
        rays.push_back({origin, random.direction(), near_m, near_m + random.uniform(1.0f, 2.0f * reach_m)});
    }
    return rays;
}
constexpr Bounds3 soup_box{.min = vec3(-10.0f), .max = vec3(10.0f)};
constexpr float edge_m = 2e-4f; // 10 eps of the largest coordinates (20 m) and distances that enter a shadow's edge
} // namespace

TEST_CASE("under a sun, the exact strip agrees with shadow rays in random soups") {
    for (const std::size_t triangle_count : {1, 16, 17, 300, 5000}) {
        CAPTURE(triangle_count);
        const float size_m = 10.0f / std::cbrt(static_cast<float>(triangle_count));
        const auto scene =
            support::make_scene({{.mesh = support::soup_mesh(triangle_count, soup_box, size_m, triangle_count)}});
        const Agreement found = agreement(*scene, sun({0.3f, -0.5f, 0.9f}), random_rays(400, 12.0f, 7), edge_m, 11);
        CHECK(found.wrong == 0);
        CHECK(found.told > 12000); // of 12,800: the edges take few
        CHECK(found.transitions > 400);
    }
}
TEST_CASE("under a lamp among the triangles, the exact strip agrees with shadow rays") {
    const auto scene = support::make_scene({{.mesh = support::soup_mesh(1000, soup_box, 1.0f, 3)}});
    for (const vec3& position : {vec3(0.0f), vec3(5.0f, -3.0f, 2.0f), vec3(0.0f, 0.0f, 40.0f)}) {
        const Agreement found = agreement(*scene, lamp(position), random_rays(400, 12.0f, 5), edge_m, 13);
        CHECK(found.wrong == 0);
        CHECK(found.told > 12000);
        CHECK(found.lit > 1000);
    }
}
TEST_CASE("mirrored, scaled and flattened instances shadow like their triangles in the world") {
    const auto mesh = support::soup_mesh(200, {.min = vec3(-1.0f), .max = vec3(1.0f)}, 0.3f, 9);
    mat4 flattened = glm::scale(mat4(1.0f), vec3(8.0f, 8.0f, 1e-3f));
    std::vector<support::Part> parts = {
        {.mesh = mesh, .world_from_object = glm::scale(mat4(1.0f), vec3(-5, 4, 3))},
        {.mesh = mesh, .world_from_object = support::translation({0, 0, 5}) * flattened}};
    for (int instance = 0; instance < 40; ++instance) // enough for a hierarchy over instances
        parts.push_back({.mesh = mesh,
                         .world_from_object =
                             support::translation(vec3(instance % 7 - 3, instance % 5 - 2, instance % 3) * vec3(3.0f)) *
                             glm::rotate(mat4(1.0f), static_cast<float>(instance), vec3(0, 0.6f, 0.8f))});
    const auto scene = support::make_scene(parts);
    for (const LightSample& light : {sun({0.2f, 0.1f, 1.0f}), lamp({1.0f, 2.0f, 7.0f})}) {
        const Agreement found = agreement(*scene, light, random_rays(400, 10.0f, 15), edge_m, 17);
        CHECK(found.wrong == 0);
        CHECK(found.told > 12000);
    }
}
