// SPDX-License-Identifier: GPL-3.0-or-later
// Lights give the light that Blender says: in total, in every direction, and at any distance. Figures "of Cycles" were
// rendered by Cycles in Blender 3.4.1 and bpy 4.5.15 (5.0.1 agrees): a light of 100 W, 2 m above a white plane.
#include "core/sobol.hpp"
#include "scene/light.hpp"
#include <array>
#include <cmath>
#include <doctest/doctest.h>
#include <numbers>

namespace light_test {
using namespace tyndall;
constexpr std::uint32_t stratum_count = 1 << 14;

static vec3 cube_point(std::uint32_t index) { return {sobol_point(index, 1), sobol_point(index, 2).x}; }

/// Irradiance at a point with a unit normal, of all strata of `light`, unoccluded.
template <typename Strata>
static dvec3 irradiance(const Strata& strata, const vec3& point, const vec3& normal) {
    dvec3 sum(0.0);
    for (std::uint32_t index = 0; index < stratum_count; ++index) {
        const LightSample sample = strata(cube_point(index));
        if (sample.is_directional) {
            sum += dvec3(sample.strength) * std::max(0.0, double{glm::dot(sample.towards_light, normal)});
            continue;
        }
        const vec3 towards_light = glm::normalize(sample.position - point);
        sum += dvec3(intensity_w_per_sr(sample, -towards_light)) * double{irradiance_per_intensity(sample, point)} *
               std::max(0.0, double{glm::dot(towards_light, normal)});
    }
    return sum / double{stratum_count};
}
/// The same without the cosine: the fluence rate, which a medium scatters.
static double fluence(const Light& light, const vec3& point) {
    double sum = 0.0;
    for (std::uint32_t index = 0; index < stratum_count; ++index) {
        const LightSample sample = sample_light(light, 0, cube_point(index));
        const vec3 from_light = glm::normalize(point - sample.position);
        sum += intensity_w_per_sr(sample, from_light).x * irradiance_per_intensity(sample, point);
    }
    return sum / stratum_count;
}
static Light lamp(LightKind kind, LightBody body, float radius_m) {
    return {.name = "lamp",
            .kind = kind,
            .strength = Rgb(static_cast<float>(100.0 / (4.0 * std::numbers::pi))),
            .position = {0, 0, 2},
            .radius_m = radius_m,
            .spot_half_angle_rad = static_cast<float>(std::numbers::pi * 50 / 180),
            .spot_blend = 0.5f,
            .body = body};
}

TEST_CASE("a sun gives a plane that faces it its strength, whatever its angle") {
    for (const float degrees : {0.0f, 0.263f, 30.0f, 60.0f, 90.0f}) {
        CAPTURE(degrees);
        const Light sun{.name = "sun",
                        .strength = {1, 2, 3},
                        .towards_light = {0.6f, 0, 0.8f},
                        .half_angle_rad = glm::radians(degrees)};
        const dvec3 facing =
            irradiance([&](const vec3& u) { return sample_light(sun, 0, u); }, {0, 0, 0}, sun.towards_light);
        CHECK(glm::length(facing / dvec3(1, 2, 3) - 1.0) < 1e-4);
    }
}
TEST_CASE("a sun of Blender 3 is a flat disc, of which Cycles 3 gives a plane 2 cos / (1 + cos) of the strength") {
    for (const auto& [degrees, of_cycles] : {std::pair{30.0f, 0.928210f}, std::pair{60.0f, 0.666661f}}) {
        const Light sun{.name = "sun",
                        .strength = Rgb(of_cycles),
                        .half_angle_rad = glm::radians(degrees),
                        .body = LightBody::FacingDisc};
        const auto strata = [&](const vec3& u) { return sample_light(sun, 0, u); };
        CHECK(std::abs(strata({0.9f, 0.2f, 0.5f}).strength.x - 1.0f) < 1e-4f);
        CHECK(std::abs(irradiance(strata, vec3(0.0f), {0, 0, 1}).x - of_cycles) < 1e-4);
    }
}
TEST_CASE("the strata of a sphere have the light's intensity on average, in every direction") {
    const Light light = lamp(LightKind::Point, LightBody::Sphere, 0.5f);
    for (std::uint32_t direction = 0; direction < 10; ++direction) {
        const vec2 p = sobol_point(direction, 5);
        const vec3 from_light = glm::normalize(vec3(p.x - 0.5f, p.y - 0.5f, p.x * p.y - 0.2f));
        double sum = 0.0;
        for (std::uint32_t index = 0; index < stratum_count; ++index)
            sum += intensity_w_per_sr(sample_light(light, 0, cube_point(index)), from_light).x;
        CHECK(std::abs(sum / stratum_count / light.strength.x - 1.0) < 1e-3);
    }
}
TEST_CASE("outside a sphere its irradiance follows the inverse square exactly, as Gauss's law says") {
    const Light light = lamp(LightKind::Point, LightBody::Sphere, 0.5f);
    for (const float distance_m : {0.8f, 1.0f, 3.0f, 100.0f}) {
        CAPTURE(distance_m);
        const vec3 point(0, 0, 2 - distance_m);
        const double exact = light.strength.x / (distance_m * distance_m);
        const auto still = irradiance([&](const vec3& u) { return sample_light(light, 0, u); }, point, {0, 0, 1});
        const auto turned =
            irradiance([&](const vec3& u) { return sample_light_towards(light, 0, vec2(u), point); }, point, {0, 0, 1});
        CHECK(std::abs(still.x / exact - 1.0) < 3e-3);
        CHECK(std::abs(turned.x / exact - 1.0) < 1e-3);
    }
}
// Seen to fail with the inverse square of the distance to the stratum: by 27 % at 2 radii, 6 % at 4.
TEST_CASE("the fluence of a facing disc is that of its solid angle, at any distance, though its strata stand still") {
    const Light light = lamp(LightKind::Point, LightBody::FacingDisc, 0.5f);
    for (const double radii : {0.5, 1.0, 1.5, 2.0, 4.0, 30.0}) {
        CAPTURE(radii);
        const double solid_angle = 2.0 * std::numbers::pi * (1.0 - radii / std::sqrt(radii * radii + 1.0));
        const double exact = light.strength.x / (std::numbers::pi * 0.25) * solid_angle;
        for (const dvec3 direction : {dvec3(1, 0, 0), dvec3(0, 0, -1), dvec3(0.48, 0.6, 0.64)})
            CHECK(std::abs(fluence(light, light.position + vec3(direction * 0.5 * radii)) / exact - 1.0) < 2e-3);
    }
}
TEST_CASE("a plane sees a facing disc as I / (d^2 + r^2), as Cycles renders it") {
    const Light light = lamp(LightKind::Point, LightBody::FacingDisc, 1.0f);
    const auto facing = irradiance([&](const vec3& u) { return sample_light_towards(light, 0, vec2(u), vec3(0.0f)); },
                                   vec3(0.0f), {0, 0, 1});
    CHECK(std::abs(facing.x / (light.strength.x / 5.0) - 1.0) < 1e-3);
}
TEST_CASE("a spot fades as in the Blender that runs, also under a scale that is not uniform") {
    struct Case {
        SpotFalloff falloff;
        float blend;
        vec3 scale;
        std::array<double, 4> of_cycles; ///< Irradiance at x = 0.4, 0.8, 1.2, 1.6 m.
    };
    const std::array<Case, 6> cases{{
        {SpotFalloff::Blender3, 0.0f, {1, 1, 1}, {1.83928, 1.47838, 1.07552, 0.73961}},
        {SpotFalloff::Blender3, 0.5f, {1, 1, 1}, {1.83928, 1.47838, 1.07552, 0.642581}},
        {SpotFalloff::Blender4, 0.0f, {1, 1, 1}, {1.87572, 1.59229, 1.25428, 0.947184}},
        {SpotFalloff::Blender4, 0.5f, {1, 1, 1}, {1.87572, 1.59229, 1.25428, 0.822925}},
        {SpotFalloff::Blender4, 0.5f, {2, 1, 1}, {1.87572, 1.59229, 1.25428, 0.947184}},
        {SpotFalloff::Blender4, 0.5f, {1, 1, 3}, {1.87572, 0, 0, 0}},
    }};
    for (const Case& c : cases) {
        CAPTURE(c.blend);
        CAPTURE(c.scale.x);
        CAPTURE(static_cast<int>(c.falloff));
        Light light = lamp(LightKind::Spot, LightBody::Sphere, 0.0f);
        light.spot_falloff = c.falloff;
        light.spot_blend = c.blend;
        light.light_from_world_directions = mat3(glm::scale(mat4(1.0f), 1.0f / c.scale));
        for (std::size_t index = 0; index < c.of_cycles.size(); ++index) {
            const vec3 point(0.4f * static_cast<float>(index + 1), 0, 0);
            const auto plane = irradiance([&](const vec3& u) { return sample_light(light, 0, u); }, point, {0, 0, 1});
            CHECK(std::abs(plane.x - c.of_cycles[index]) <= 1e-3 * c.of_cycles[index]);
        }
    }
}
TEST_CASE("a light without a size is one stratum, the same for every u") {
    const Light light = lamp(LightKind::Spot, LightBody::FacingDisc, 0.0f);
    const LightSample sample = sample_light(light, 3, {0.9f, 0.1f, 0.3f});
    CHECK(sample.position == light.position);
    CHECK(sample.light_index == 3);
    CHECK(sample.spot == &light);
    CHECK(sample.softening_m2 == 0.0f);
}

TEST_CASE("surfaces tell lights apart by what they see of them: not by names, nor by edits for the air alone") {
    const Light lamp{.name = "lamp", .kind = LightKind::Point, .position = {0, 0, 3}, .radius_m = 0.1f};
    Light other = lamp;
    other.name = "other";
    other.scatters_in_media = false;
    other.occluder_edits = {{.name = "close", .kind = EditKind::Close}, {.name = "holes", .kind = EditKind::Holes}};
    CHECK(lights_surfaces_alike(lamp, other));
    other.occluder_edits[1].affects_surfaces = true;
    CHECK(!lights_surfaces_alike(lamp, other));
    Light same_holes = other;
    same_holes.occluder_edits[0].size_m *= 2.0f;
    CHECK(lights_surfaces_alike(other, same_holes));
    same_holes.occluder_edits[1].noise.turn_rad = 0.5f;
    CHECK(!lights_surfaces_alike(other, same_holes));
    Light filled = other;
    filled.occluder_edits[0].affects_surfaces = true;
    CHECK(!lights_surfaces_alike(other, filled));
    Light filled_alike = filled;
    filled_alike.occluder_edits[0].name = "filled";
    filled_alike.occluder_edits[0].noise.seed = 5; // which filling does not read
    CHECK(lights_surfaces_alike(filled, filled_alike));
    filled_alike.occluder_edits[0].size_m *= 2.0f;
    CHECK(!lights_surfaces_alike(filled, filled_alike));
    for (auto change : {+[](Light& light) { light.position.x += 1.0f; }, +[](Light& light) { light.strength.y *= 2; },
                        +[](Light& light) { light.radius_m = 0.2f; }, +[](Light& light) { light.casts_shadow = false; },
                        +[](Light& light) { light.kind = LightKind::Spot; }}) {
        Light changed = lamp;
        change(changed);
        CHECK(!lights_surfaces_alike(lamp, changed));
    }
}
} // namespace light_test
