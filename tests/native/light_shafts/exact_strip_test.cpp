// SPDX-License-Identifier: GPL-3.0-or-later
// EXACT is the truth of all other shaft tests, so it is held against rays: at random points of random view rays it must
// say what Embree says, whatever the occluders, the light, the transform.
#include "core/simd.hpp"
#include "light_shafts/exact_strip.hpp"
#include "support/close_to.hpp"
#include "support/soup.hpp"
#include <doctest/doctest.h>

namespace exact_strip_test {
using namespace tyndall;
using tyndall::support::close_to;
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

TEST_CASE("every instruction set finds the same shadows") {
    const auto scene = support::make_scene({{support::soup_mesh(500, soup_box, 1.2f, 31)}});
    const std::vector<ViewRay> rays = random_rays(300, 12.0f, 33);
    for (const LightSample& light : {sun({0.3f, -0.5f, 0.9f}), lamp({1.0f, 2.0f, 3.0f})}) {
        const LitRows reference = lit_rows(*scene, light, rays);
        for (const SimdTarget target : available_simd_targets()) {
            const ForcedSimdTarget forced(target);
            CAPTURE(simd_target_name());
            const LitRows rows = lit_rows(*scene, light, rays);
            REQUIRE(rows.first == reference.first);
            for (std::size_t index = 0; index < rows.intervals.size(); ++index) {
                // Fused multiply-adds or not: 2 eps of 25 m, over the sine of a flat angle.
                CHECK(std::abs(rows.intervals[index].near_m - reference.intervals[index].near_m) < 2e-4f);
                CHECK(std::abs(rows.intervals[index].far_m - reference.intervals[index].far_m) < 2e-4f);
            }
        }
    }
}
TEST_CASE(
    "rays straight along or against the sun, as in an orthographic view from it, are lit behind the last triangle") {
    const auto scene = support::make_scene({{support::soup_mesh(300, soup_box, 2.0f, 41)}});
    const LightSample light = sun({0.3f, -0.5f, 0.9f});
    support::SceneRandom random(43);
    int wrong = 0, told = 0, partly_lit = 0;
    for (int index = 0; index < 400; ++index) {
        const vec3 direction = index % 2 == 0 ? light.towards_light : -light.towards_light;
        const vec3 origin = 9.0f * vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
        const ViewRay ray{origin, direction, 0.0f, 10.0f};
        const LitRows rows = lit_rows(*scene, light, {&ray, 1});
        partly_lit += !rows.intervals.empty();
        for (int sample = 0; sample < 16; ++sample) {
            const float t = random.uniform(0.0f, 10.0f);
            if (distance_to_end(rows.intervals, t) < edge_m)
                continue;
            ++told;
            wrong += shadow_ray(*scene, light, origin + t * direction) != transmittance_at(rows.intervals, t);
        }
    }
    // The tilt of 1e-6 rad moves what it sees by 20 um: of 6,400 points none should stand that close to an edge.
    CHECK(wrong == 0);
    CHECK(told > 6000);
    CHECK(partly_lit > 100);
}
TEST_CASE("rays past a lamp, and straight through it") {
    const auto scene = support::make_scene({{support::soup_mesh(300, soup_box, 1.5f, 51)}});
    const vec3 position(1.0f, -2.0f, 0.5f);
    support::SceneRandom random(53);
    for (const float offset_m : {0.0f, 1e-7f, 1e-4f, 1e-2f}) {
        CAPTURE(offset_m);
        int wrong = 0, told = 0;
        for (int index = 0; index < 200; ++index) {
            const vec3 direction = random.direction();
            const vec3 across = orthonormal_basis(direction).first;
            const ViewRay ray{position - 8.0f * direction + offset_m * across, direction, 0.0f, 16.0f};
            const LitRows rows = lit_rows(*scene, lamp(position), {&ray, 1});
            for (int sample = 0; sample < 16; ++sample) {
                const float t = random.uniform(0.0f, 16.0f);
                if (distance_to_end(rows.intervals, t) < 1e-3f || std::abs(t - 8.0f) < 1e-2f)
                    continue;
                ++told;
                wrong += shadow_ray(*scene, lamp(position), ray.origin + t * direction) !=
                         transmittance_at(rows.intervals, t);
            }
        }
        // A triangle's edge within the light's offset of the ray casts a shadow whose end no float can place.
        CHECK(wrong <= told / 300);
        CHECK(told > 2500);
    }
}
TEST_CASE("60 km from the origin, and in units of a micrometre or a thousand kilometres") {
    const auto mesh = support::soup_mesh(300, soup_box, 2.0f, 61);
    const vec3 far_away(60000.0f, -60000.0f, 100.0f);
    std::vector<ViewRay> rays = random_rays(300, 12.0f, 63);
    for (const float scale : {1e-6f, 1e6f}) {
        CAPTURE(scale);
        std::vector<ViewRay> scaled = rays;
        for (ViewRay& ray : scaled)
            ray.origin *= scale, ray.near_m *= scale, ray.far_m *= scale;
        const auto scene = support::make_scene({{mesh, glm::scale(mat4(1.0f), vec3(scale))}});
        const Agreement found = agreement(*scene, sun({0.3f, -0.5f, 0.9f}), scaled, scale * edge_m, 65);
        CHECK(found.wrong == 0);
        CHECK(found.told > 9000);
    }
    for (ViewRay& ray : rays)
        ray.origin += far_away;
    const auto scene = support::make_scene({{mesh, support::translation(far_away)}});
    const Agreement found =
        agreement(*scene, sun({0.3f, -0.5f, 0.9f}), rays, 0.05f, 67); // floats stand 8 mm apart there
    CHECK(found.wrong == 0);
    CHECK(found.told > 8000);
}
TEST_CASE("a lamp inside a closed occluder lights nothing outside of it, and all of its inside") {
    const auto scene = support::make_scene({{support::cube()}});
    std::vector<ViewRay> rays = random_rays(200, 4.0f, 71);
    const LitRows rows = lit_rows(*scene, lamp({0.3f, 0.2f, -0.1f}), rays);
    for (std::size_t ray = 0; ray < rays.size(); ++ray) {
        const BoxInterval inside = clip_to_box({vec3(-1.0f), vec3(1.0f)}, rays[ray].origin, rays[ray].direction);
        const float near_m = std::max(inside.near_m, rays[ray].near_m), far_m = std::min(inside.far_m, rays[ray].far_m);
        float lit_m = 0.0f;
        for (std::uint32_t index = rows.first[ray]; index < rows.first[ray + 1]; ++index)
            lit_m += rows.intervals[index].far_m - rows.intervals[index].near_m;
        CHECK(std::abs(lit_m - std::max(0.0f, far_m - near_m)) < 1e-4f);
    }
}
TEST_CASE("a ray that ends on a floor is lit to its end, one under it is dark, one along it is one or the other") {
    const auto scene = support::make_scene({{support::square(), glm::scale(mat4(1.0f), vec3(10.0f))}});
    const LightSample light = sun({0.2f, 0.1f, 1.0f});
    const ViewRay down{{0, 0, 5}, glm::normalize(vec3(0.3f, 0.4f, -1.0f)), 0.0f, 5.0f * std::sqrt(1.25f)};
    const LitRows hit = lit_rows(*scene, light, {&down, 1});
    REQUIRE(hit.intervals.size() == 1);
    CHECK(hit.intervals[0].near_m == 0.0f);
    CHECK(std::abs(hit.intervals[0].far_m - down.far_m) < 1e-5f);
    for (const float height : {-1e-4f, 0.0f, 1e-4f}) {
        const ViewRay along{{-5, 0, height}, {1, 0, 0}, 0.0f, 8.0f};
        const LitRows rows = lit_rows(*scene, light, {&along, 1});
        float lit_m = 0.0f;
        for (const LitInterval& lit : rows.intervals)
            lit_m += lit.far_m - lit.near_m;
        CHECK(lit_m == close_to(height > 0.0f ? 8.0f : height < 0.0f ? 0.0f : lit_m, 1e-5));
        CHECK(lit_m <= 8.0f);
    }
}

namespace {
/// Transparent where the checkerboard's alpha is 0; `transparency` of the rest passes.
Material checkerboard(float transparency) {
    Texture texture{.name = "checkerboard", .width = 8, .height = 8};
    std::vector<float> texels;
    for (int texel = 0; texel < 64; ++texel)
        texels.insert(texels.end(), {1.0f, 1.0f, 1.0f, (texel + texel / 8) % 2 ? 1.0f : 0.0f});
    texture.floats = std::move(texels);
    texture.is_srgb = false, texture.has_alpha = true;
    texture.interpolation = TextureInterpolation::Closest;
    Material material{.name = "leaf"};
    material.program = {
        {.code = SurfaceOp::Code::TextureAlpha, .out = 0},
        {.code = SurfaceOp::Code::Constant, .out = 1, .value = Rgb(1.0f)},
        {.code = SurfaceOp::Code::Constant, .out = 2, .value = Rgb(transparency, 0.5f * transparency, 0.0f)},
        {.code = SurfaceOp::Code::Mix, .out = 3, .a = 1, .b = 2, .c = 0}};
    material.transparent_register = 3, material.diffuse_register = 2, material.emission_register = 2;
    material.textures = {std::make_shared<const Texture>(texture)};
    material.uv_map_names = {""};
    return material;
}
} // namespace
TEST_CASE("alpha textures and panes of glass let through what a shadow ray says, texel by texel") {
    Material pane{.name = "pane"};
    pane.constant.transparent = {0.5f, 0.25f, 1.0f};
    std::vector<support::Part> parts;
    for (int layer = 0; layer < 3; ++layer)
        parts.push_back({.mesh = support::square(),
                         .world_from_object = glm::rotate(support::translation({0, 0.3f * static_cast<float>(layer),
                                                                                2.0f + static_cast<float>(layer)}),
                                                          0.4f * static_cast<float>(layer), vec3(1, 0.3f, 0.2f)) *
                                              glm::scale(mat4(1.0f), vec3(4.0f)),
                         .material = layer == 0 ? pane : checkerboard(layer == 1 ? 0.0f : 0.3f)});
    parts.push_back({.mesh = support::soup_mesh(10, soup_box, 1.5f, 81)});
    const auto scene = support::make_scene(parts);
    for (const LightSample& light : {sun({0.1f, 0.2f, 1.0f}), lamp({0.5f, 0.2f, 9.0f})}) {
        const Agreement found = agreement(*scene, light, random_rays(300, 4.0f, 83), edge_m, 85);
        CHECK(found.wrong == 0);
        CHECK(found.told > 9000);
        CHECK(found.transitions > 600);
    }
}
} // namespace exact_strip_test
