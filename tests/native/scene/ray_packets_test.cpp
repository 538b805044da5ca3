// SPDX-License-Identifier: GPL-3.0-or-later
// Rays in packets find what the same rays find alone: through instances, panes, holes and masks.
#include "core/random.hpp"
#include "core/sobol.hpp"
#include "support/panes_and_holes.hpp"
#include "support/scenes.hpp"
#include <doctest/doctest.h>

namespace ray_packets_test {
using namespace tyndall;
using namespace tyndall::support;

namespace {
/// A crowd of turned cubes and squares: opaque, see-through, unseen by the camera, or without a shadow. One mesh has a
/// slot without a surface: a hole.
std::unique_ptr<Scene> crowd() {
    SceneDescription description = panes_and_holes();
    description.object_names = {"crowd"};
    for (std::uint32_t index = 0; index < 60; ++index) {
        const auto number = [&](std::uint32_t dimension) { return unit_float(hash(index, dimension)); };
        const vec3 place(4.0f * number(0) - 2.0f, 4.0f * number(1) - 2.0f, 6.0f * number(2));
        const mat4 turned =
            glm::rotate(translation(place), 6.0f * number(3), glm::normalize(vec3(number(4), number(5), 0.1f)));
        description.instances.push_back({.mesh_index = index % 3,
                                         .world_from_object = glm::scale(turned, vec3(0.1f + 0.5f * number(6))),
                                         .first_slot_material = index % 2 * 2,
                                         .slot_count = 2,
                                         .is_camera_visible = index % 7 != 0,
                                         .casts_shadow = index % 5 != 0});
    }
    return std::make_unique<Scene>(std::move(description), Progress());
}

/// Rays of a square of neighbouring pixels, through the crowd.
std::vector<Ray> neighbouring_rays(std::uint32_t seed, std::size_t count, float spread) {
    const vec2 at = 2.0f * sobol_point(seed, 1) - 1.0f;
    std::vector<Ray> rays;
    for (std::size_t index = 0; index < count; ++index) {
        const vec2 beside = spread * sobol_point(static_cast<std::uint32_t>(index), seed);
        const vec3 target(at + beside, -3.0f);
        const vec3 origin(0.1f * at, 9.0f);
        rays.push_back({.origin = origin, .direction = glm::normalize(target - origin)});
    }
    return rays;
}
} // namespace

TEST_CASE("rays in packets hit what they hit alone, whatever their number and spread") {
    const auto scene = crowd();
    std::size_t hit_count = 0;
    for (std::uint32_t seed = 0; seed < 400; ++seed) {
        const std::vector<Ray> rays = neighbouring_rays(seed, 1 + seed % 40, seed % 3 == 0 ? 3.0f : 0.02f);
        std::vector<Hit> hits(rays.size());
        scene->closest_hits(rays, hits);
        for (std::size_t index = 0; index < rays.size(); ++index) {
            const Hit alone = scene->closest_hit(rays[index]);
            REQUIRE(hits[index].is_hit() == alone.is_hit());
            if (!alone.is_hit())
                continue;
            ++hit_count;
            // A point on an edge belongs to two triangles: the distance is what both agree on.
            CHECK(std::abs(hits[index].distance_m - alone.distance_m) <= 1e-6f * alone.distance_m);
            if (hits[index].triangle == alone.triangle && hits[index].instance == alone.instance)
                CHECK(hits[index].geometric_normal == alone.geometric_normal);
        }
    }
    CHECK(hit_count > 1000);
}

// Seen to fail with the transmittance of every hit multiplied into the first ray's.
TEST_CASE("light in packets passes through the same panes as alone, ray by ray") {
    const auto scene = crowd();
    std::size_t partly_count = 0;
    for (std::uint32_t seed = 0; seed < 400; ++seed) {
        const std::vector<Ray> rays = neighbouring_rays(seed, 1 + seed % 40, seed % 3 == 0 ? 3.0f : 0.02f);
        std::vector<Rgb> passing(rays.size());
        scene->shadow_transmittances(rays, passing);
        for (std::size_t index = 0; index < rays.size(); ++index) {
            const Rgb alone = scene->shadow_transmittance(rays[index]);
            // The same factors in another order.
            CHECK(glm::length(passing[index] - alone) <= 1e-5f * glm::length(alone));
            partly_count += alone.x > 0.0f && alone.x < 1.0f;
        }
    }
    CHECK(partly_count > 100);
}
} // namespace ray_packets_test
