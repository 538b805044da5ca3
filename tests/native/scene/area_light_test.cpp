// SPDX-License-Identifier: GPL-3.0-or-later
// Area lights give what radiometry says: closed forms of their irradiance near and far, their watts through a sphere.
#include "core/sobol.hpp"
#include "scene/area_light.hpp"
#include "scene/light_axes.hpp"
#include "support/area_lights.hpp"
#include <array>
#include <cmath>
#include <doctest/doctest.h>
#include <numbers>

namespace area_light_test {
using namespace tyndall;
using namespace tyndall::support;

namespace {
struct Estimate {
    double mean, deviation; ///< Of one stratum.
};
Estimate irradiance(const Light& light, const vec3& point, const vec3& normal, std::uint32_t stratum_count = 1 << 12,
                    std::uint32_t seed = 1) {
    double sum = 0.0, squares = 0.0;
    for (std::uint32_t index = 0; index < stratum_count; ++index) {
        const LightSample sample = sample_light_towards(light, 0, sobol_point(index, seed), point);
        const vec3 way = sample.position - point, towards = glm::normalize(way);
        const double value = double{intensity_w_per_sr(sample, -towards).x} / double{glm::dot(way, way)} *
                             std::max(0.0, double{glm::dot(towards, normal)});
        sum += value;
        squares += value * value;
    }
    const double mean = sum / stratum_count;
    return {mean, std::sqrt(std::max(0.0, squares / stratum_count - mean * mean))};
}
} // namespace

// Seen to fail with the corners of its box lit, too.
TEST_CASE("a disc gives a plane on its axis radiance times pi r^2 / (r^2 + z^2), from its rim's distance to a hair's") {
    Light light = area_light({0.5f, 0.5f});
    light.is_ellipse = true;
    const double radiance = light.strength.x / (std::numbers::pi * 0.25);
    for (const float height : {1e-3f, 0.05f, 0.3f, 0.5f, 0.7f, 2.0f, 50.0f}) {
        CAPTURE(height);
        const double exact = radiance * std::numbers::pi * 0.25 / (0.25 + double{height} * height);
        CHECK(std::abs(irradiance(light, before(light, {0, 0}, height), -light.spot_axis).mean / exact - 1.0) < 3e-3);
    }
}

// Seen to fail with the square of the distance in place of what makes a density per area of one per solid angle.
TEST_CASE("a rectangle gives what Lambert's formula says: near, far, beside it, grazing, half below the horizon") {
    const Light light = area_light({0.8f, 0.3f});
    struct Place {
        vec2 foot;
        float height;
        vec3 normal; ///< In the light's axes.
    };
    const std::array places{Place{{0, 0}, 1e-3f, {0, 0, 1}},          Place{{0.2f, -0.1f}, 0.02f, {0, 0.6f, 0.8f}},
                            Place{{0, 0}, 0.5f, {0, 0, 1}},           Place{{0.5f, 0.2f}, 3.0f, {0.6f, 0, 0.8f}},
                            Place{{1.5f, 0.0f}, 0.2f, {-1, 0, 0}},    Place{{3.0f, 1.0f}, 0.05f, {-1, 0, 0}},
                            Place{{0.81f, 0.0f}, 0.003f, {-1, 0, 0}}, Place{{0, 0}, 0.1f, {1, 0, 0}},
                            Place{{0, 0}, 40.0f, {0, 0, 1}},          Place{{-0.9f, 0.5f}, 0.4f, {0.3f, -0.9f, 0.1f}}};
    for (const Place& place : places) {
        CAPTURE(place.foot.x);
        CAPTURE(place.height);
        const vec3 point = before(light, place.foot, place.height);
        const vec3 normal = glm::normalize(light_axes(light) * place.normal);
        const double exact = lambert(light, point, normal);
        const Estimate ours = irradiance(light, point, normal, 1 << 14);
        CHECK(std::abs(ours.mean / exact - 1.0) < 4e-3);
        if (place.normal.z == 1.0f) // all of it above the horizon: only the cosine varies
            CHECK(ours.deviation < 0.6 * ours.mean);
    }
}

TEST_CASE("whatever its shape, its watts pass through a sphere around it, and none to its back") {
    for (const bool is_ellipse : {false, true})
        for (const float degrees : {180.0f, 120.0f, 30.0f, 4.0f, 0.5f}) {
            CAPTURE(is_ellipse);
            CAPTURE(degrees);
            Light light = area_light({0.5f, 0.2f});
            light.is_ellipse = is_ellipse;
            light.spot_half_angle_rad = glm::radians(0.5f * degrees);
            // On a sphere of 30 m, over the cap that its cone may reach from any of its points.
            constexpr float radius_m = 30.0f;
            const double cap_rad =
                std::min(0.5 * std::numbers::pi, double{light.spot_half_angle_rad} + std::asin(0.6 / radius_m));
            double flux_w = 0.0;
            constexpr std::uint32_t count = 1 << 14;
            for (std::uint32_t index = 0; index < count; ++index) {
                const vec3 outwards =
                    from_frame(light.spot_axis,
                               sample_uniform_cone(sobol_point(index, 4), one_minus_cos(static_cast<float>(cap_rad))));
                const vec3 point = light.position + radius_m * outwards;
                flux_w += irradiance(light, point, -outwards, 8, hash(index)).mean;
            }
            flux_w *= 2.0 * std::numbers::pi * (1.0 - std::cos(cap_rad)) * radius_m * radius_m / count;
            CHECK(std::abs(flux_w / (std::numbers::pi * light.strength.x) - 1.0) < 0.01);
            for (std::uint32_t index = 0; index < 64; ++index) {
                const vec3 behind = sample_cosine_hemisphere(sobol_point(index, 2));
                CHECK(
                    irradiance(light, light.position - from_frame(light.spot_axis, behind), light.spot_axis, 16).mean ==
                    0.0);
            }
        }
}

TEST_CASE("strata that stand still are on average the light that is sampled for the receiver") {
    for (const bool is_ellipse : {false, true})
        for (const float degrees : {180.0f, 90.0f, 20.0f}) {
            Light light = area_light({0.6f, 0.25f});
            light.is_ellipse = is_ellipse;
            light.spot_half_angle_rad = glm::radians(0.5f * degrees);
            for (const auto& [foot, height] :
                 {std::pair{vec2(0, 0), 1.0f}, {vec2(0.3f, -0.1f), 2.5f}, {vec2(0.5f, 0), 4.0f}}) {
                CAPTURE(degrees);
                CAPTURE(height);
                const vec3 point = before(light, foot, height);
                const vec3 normal = glm::normalize(light_axes(light) * vec3(0.2f, 0.1f, 1.0f));
                double still = 0.0;
                constexpr std::uint32_t count = 1 << 14;
                for (std::uint32_t index = 0; index < count; ++index) {
                    const LightSample sample = sample_light(light, 0, {sobol_point(index, 3), 0.0f});
                    const vec3 from_light = glm::normalize(point - sample.position);
                    still += double{intensity_w_per_sr(sample, from_light).x} *
                             irradiance_per_intensity(sample, point) * std::max(0.0f, glm::dot(normal, -from_light)) /
                             count;
                }
                CHECK(std::abs(irradiance(light, point, normal, 1 << 14).mean / still - 1.0) < 5e-3);
            }
        }
}

// A light of 100 W, 1 m wide, 2 m above a white plane: Cycles 4.5.15, the mean over the 16 m^2 below it.
TEST_CASE("its spread dims as Cycles' slats do") {
    for (const auto& [degrees, of_cycles] : {std::pair{180.0f, 1.08412}, {90.0f, 1.97589}, {30.0f, 1.98092}}) {
        CAPTURE(degrees);
        Light light = area_light({0.5f, 0.5f});
        light.position = {0, 0, 2};
        light.spot_axis = {0, 0, -1};
        light.light_from_world_directions = mat3(1.0f);
        light.strength = Rgb(static_cast<float>(100.0 / std::numbers::pi));
        light.spot_half_angle_rad = glm::radians(0.5f * degrees);
        double mean = 0.0;
        constexpr std::uint32_t count = 1 << 12;
        for (std::uint32_t index = 0; index < count; ++index) {
            const vec3 point((sobol_point(index, 7) - 0.5f) * 4.0f, 0.0f);
            mean += irradiance(light, point, {0, 0, 1}, 16, hash(index)).mean / std::numbers::pi / count;
        }
        CHECK(std::abs(mean / of_cycles - 1.0) < 0.01);
    }
}
} // namespace area_light_test
