// SPDX-License-Identifier: GPL-3.0-or-later
// Sixteen points at a time get what scene/light.hpp gives one; and what a light is said not to reach, no part of it lights.
#include "core/simd.hpp"
#include "core/sobol.hpp"
#include "render/light_aim.hpp"
#include "render/pixel_samples.hpp"
#include <cmath>
#include <doctest/doctest.h>
#include <string>
#include <vector>

using namespace tyndall;

namespace {
struct Arriving {
    vec3 direction;
    float far_m;
    float irradiance; ///< Of a light of strength 1, with a spot's cone.
};
/// One stratum, by scene/light.hpp.
Arriving arriving_at(const Light& light, vec2 u, const vec3& position, const vec3& normal) {
    const LightSample sample = sample_light_towards(light, 0, u, position);
    if (sample.is_directional)
        return {sample.towards_light, std::numeric_limits<float>::infinity(),
                std::max(0.0f, glm::dot(normal, sample.towards_light)) * sample.strength.x};
    const vec3 way = sample.position - position;
    const float distance_m = glm::length(way);
    const vec3 direction = way / distance_m;
    return {direction, distance_m,
            std::max(0.0f, glm::dot(normal, direction)) * intensity_w_per_sr(sample, -direction).x /
                (distance_m * distance_m)};
}
/// A flat surface, left without an offset.
void set_point(render::LitPoints& points, std::size_t lane, const vec3& position, const vec3& normal,
               std::uint32_t pixel_seed) {
    points.set(lane, position, normal, {.position = position, .normal = normal, .offset_m = 0.0f}, pixel_seed);
}
vec3 random_unit(std::uint32_t index, std::uint32_t seed) {
    const vec2 u = sobol_point(index, seed);
    const float z = 2.0f * u.x - 1.0f, around = 6.2831853f * u.y, across = std::sqrt(std::max(0.0f, 1.0f - z * z));
    return {across * std::cos(around), across * std::sin(around), z};
}
Light turned_light(LightKind kind, const vec3& axis) {
    Light light;
    light.kind = kind;
    light.position = {1, 2, 3};
    light.towards_light = axis;
    light.spot_axis = -axis;
    const auto [tangent, bitangent] = orthonormal_basis(axis);
    light.light_from_world_directions = glm::transpose(mat3(tangent, bitangent, axis));
    return light;
}
struct Case {
    std::string name;
    Light light;
};
std::vector<Case> cases() {
    const vec3 axis = glm::normalize(vec3(0.3f, -0.5f, 0.8f));
    std::vector<Case> result;
    for (const float half_angle : {0.0f, 0.3f, 1.57f}) {
        Light sun = turned_light(LightKind::Sun, axis);
        sun.half_angle_rad = half_angle;
        result.push_back({"sun " + std::to_string(half_angle), sun});
    }
    for (const float radius_m : {0.0f, 0.4f})
        for (const LightBody body : {LightBody::Sphere, LightBody::FacingDisc}) {
            Light point = turned_light(LightKind::Point, axis);
            point.radius_m = radius_m;
            point.body = body;
            result.push_back({"point " + std::to_string(radius_m), point});
            for (const SpotFalloff falloff : {SpotFalloff::Blender3, SpotFalloff::Blender4})
                for (const float half_angle : {0.05f, 0.7f, 1.55f}) {
                    Light spot = point;
                    spot.kind = LightKind::Spot;
                    spot.spot_half_angle_rad = half_angle;
                    spot.spot_blend = 0.3f;
                    spot.spot_falloff = falloff;
                    result.push_back({"spot " + std::to_string(half_angle), spot});
                    spot.light_from_world_directions =
                        mat3(vec3(2, 0, 0), vec3(0, 0.5f, 0), vec3(0, 0, 1)) * spot.light_from_world_directions;
                    if (falloff == SpotFalloff::Blender4)
                        result.push_back({"stretched spot " + std::to_string(half_angle), spot});
                }
        }
    return result;
}
} // namespace

// Seen to fail with the cone's cosine in place of 1 - cos, and with the disc's axis turned round.
TEST_CASE("a light aimed at 16 points at once is the light aimed at each, on every instruction set") {
    for (const SimdTarget target : available_simd_targets()) {
        const ForcedSimdTarget forced(target);
        for (const auto& [name, light] : cases()) {
            CAPTURE(name);
            const render::LightAim aim(light);
            std::size_t lit_count = 0;
            for (std::uint32_t group = 0; group < 40; ++group) {
                render::LitPoints points;
                for (std::uint32_t lane = 0; lane < 13; ++lane) { // not all of the 16
                    const std::uint32_t index = group * 16 + lane;
                    // Inside the sphere, and outside; not where its rim is at right angles, an ill-conditioned root.
                    const float distance_m = lane == 0 ? 0.2f : 0.5f + 8.0f * sobol_point(index, 3).x;
                    set_point(points, lane, light.position + distance_m * random_unit(index, 1), random_unit(index, 2),
                              hash(index));
                }
                render::AimedRays rays;
                const render::LaneSet lit = aim.aim(points, {.sample_index = 5, .pair_index = group}, rays);
                CHECK(lit < 1u << 13);
                for (std::uint32_t lane = 0; lane < 13; ++lane) {
                    const vec2 u = render::pixel_pair(points.pixel_seeds[lane], 5, group);
                    const vec3 position = points.position.get(lane), normal = points.shading_normal.get(lane);
                    Light without_cone = light; // the caller's share
                    if (light.kind == LightKind::Spot)
                        without_cone.kind = LightKind::Point;
                    const Arriving alone = arriving_at(without_cone, u, position, normal);
                    if ((lit >> lane & 1) == 0) {
                        CHECK(alone.irradiance < 1e-5f);
                        continue;
                    }
                    ++lit_count;
                    // Rounding of an angle moves a sun's or a disc's edge by a few units in the last place of 1.
                    CHECK(glm::length(rays.direction.get(lane) - alone.direction) < 4e-6f);
                    CHECK(std::abs(rays.weight[lane] - alone.irradiance) < 2e-5f * alone.irradiance + 1e-6f);
                    if (std::isfinite(alone.far_m)) // half a chord is the root of a small difference
                        CHECK(std::abs(rays.far_m[lane] - alone.far_m) < 1e-3f * alone.far_m);
                    else
                        CHECK(rays.far_m[lane] == alone.far_m);
                }
            }
            CHECK(lit_count > 100);
        }
    }
}

TEST_CASE("rays leave a point on the side to which they go") {
    Light light = turned_light(LightKind::Point, {0, 0, 1});
    for (const float side : {-1.0f, 1.0f}) {
        light.position = {0.5f, 0, 3.0f * side};
        render::LitPoints points;
        // A surface whose own normal is +Z, seen from the light's side.
        points.set(0, vec3(0.0f), {0, 0, side}, {.position = vec3(0.0f), .normal = {0, 0, 1}, .offset_m = 0.01f}, 7);
        render::AimedRays rays;
        REQUIRE(render::LightAim(light).aim(points, {}, rays) == 1);
        CHECK(rays.origin.get(0) == vec3(0, 0, 0.01f * side));
        CHECK(glm::length(rays.origin.get(0) + rays.far_m[0] * rays.direction.get(0) - light.position) < 1e-6f);
    }
}

// Seen to fail with the sphere of a spot left out of the test of its cone.
TEST_CASE("a light that is said not to reach a point has no part that lights it") {
    constexpr std::uint32_t point_count = 3000, stratum_count = 32;
    for (const auto& [name, light] : cases()) {
        CAPTURE(name);
        const render::LightAim aim(light);
        std::size_t dark_count = 0, skipped_count = 0;
        for (std::uint32_t index = 0; index < point_count; ++index) {
            const float distance_m = 0.5f + 5.0f * sobol_point(index, 3).x;
            // Half of the points along the spot's axis, where narrow cones are.
            const vec3 way =
                index % 2 == 0 ? random_unit(index, 1) : glm::normalize(light.spot_axis + 0.2f * random_unit(index, 1));
            const vec3 position = light.position + distance_m * way, normal = random_unit(index, 2);
            bool is_lit = false;
            for (std::uint32_t stratum = 0; stratum < stratum_count; ++stratum)
                is_lit |=
                    arriving_at(light, sobol_point(stratum, hash(index, 9u)), position, normal).irradiance > 1e-6f;
            dark_count += !is_lit;
            render::LitPoints points;
            set_point(points, index % 16, position, normal, 0);
            const bool is_skipped = aim.may_light(points) == 0;
            skipped_count += is_skipped;
            REQUIRE_FALSE((is_lit && is_skipped));
        }
        if (light.kind != LightKind::Sun || light.half_angle_rad < 1.0f)
            CHECK(static_cast<double>(skipped_count) > 0.75 * static_cast<double>(dark_count));
    }
}
