// SPDX-License-Identifier: GPL-3.0-or-later
// Irradiance from an image of the world, against the integral over the sphere; and what is said about light left out.
#include "core/random.hpp"
#include "render/direct_light.hpp"
#include "support/environment_images.hpp"
#include "support/scenes.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <doctest/doctest.h>
#include <numbers>

namespace direct_light_test {
using namespace tyndall;
using namespace tyndall::support;

namespace {
/// Dim noise with one texel that holds most of the light: hard for the cosine, easy for the image's own sampling.
World bright_spot_world() {
    std::vector<Rgb> colours;
    for (std::uint32_t texel = 0; texel < 16 * 8; ++texel)
        colours.push_back(Rgb(0.2f + unit_float(hash(texel)), 0.5f, unit_float(hash(texel, 1u))));
    colours[6 * 16 + 5] = Rgb(80.0f, 60.0f, 40.0f);
    return World("sky", Rgb(1.0f), support::environment_image(16, 8, colours));
}
/// Integral of radiance times cosine over the upper hemisphere by the midpoint rule.
glm::dvec3 irradiance_by_quadrature(const World& world) {
    constexpr int rings = 1000, sectors = 4000;
    glm::dvec3 sum(0.0);
    for (int ring = 0; ring < rings; ++ring)
        for (int sector = 0; sector < sectors; ++sector) {
            // Steps of equal size in cos^2: each has the same share of the cosine's integral, pi.
            const double cosine = std::sqrt((ring + 0.5) / rings), sine = std::sqrt(1.0 - cosine * cosine);
            const double azimuth = 2.0 * std::numbers::pi * (sector + 0.5) / sectors;
            sum += glm::dvec3(world.radiance(vec3(sine * std::cos(azimuth), sine * std::sin(azimuth), cosine)));
        }
    return sum * (std::numbers::pi / (double{rings} * sectors));
}
} // namespace

TEST_CASE("an image of the world lights a plane by its integral over the hemisphere") {
    SceneDescription description = description_of(*make_scene({{.mesh = square()}}));
    description.world = bright_spot_world();
    const Scene scene(std::move(description), Progress());
    const Media media(scene, Progress());
    Statistics statistics;
    const render::DirectLight light(scene, media, statistics);
    const Ray down{.origin = {0.3f, 0.2f, 5.0f}, .direction = {0, 0, -1}};
    const Hit hit = scene.closest_hit(down);
    render::SurfacePoint point = render::surface_point(scene, down, hit, 0);
    constexpr std::array<std::uint8_t, 1> only_light{1};
    glm::dvec3 sum(0.0), sum_of_squares(0.0);
    constexpr std::uint32_t run_count = 16, sample_count = 1024;
    for (std::uint32_t run = 0; run < run_count; ++run) {
        glm::dvec3 mean(0.0);
        for (std::uint32_t sample = 0; sample < sample_count; ++sample) {
            point.pixel_seed = run;
            render::DirectLight::Irradiance irradiance;
            light.at({&point, 1}, {.sample_index = sample, .pair_index = 0}, only_light, {&irradiance, 1});
            mean += glm::dvec3(irradiance.from_world) / double{sample_count};
        }
        sum += mean;
        sum_of_squares += mean * mean;
    }
    const glm::dvec3 mean = sum / double{run_count};
    const glm::dvec3 variance = glm::max(sum_of_squares / double{run_count} - mean * mean, glm::dvec3(0.0));
    const glm::dvec3 truth = irradiance_by_quadrature(scene.world());
    for (int channel = 0; channel < 3; ++channel) {
        const double sigma = std::sqrt(variance[channel] / (run_count - 1));
        CHECK(sigma < 3e-3 * truth[channel]); // with one ray a sample
        CHECK(std::abs(mean[channel] - truth[channel]) < 4.0 * sigma + 1e-4 * truth[channel]);
    }
}

TEST_CASE("a mesh that glows is one of the lights, and nothing is left to report of it where no fog is") {
    Material lamp{.name = "Tube"};
    lamp.constant.emission = Rgb(10.0f);
    const auto scene = make_scene({{.mesh = square(), .material = lamp}, {.mesh = square()}});
    const Media media(*scene, Progress());
    Statistics statistics;
    const render::DirectLight light(*scene, media, statistics);
    CHECK(statistics.reports.empty());
    REQUIRE(light.light_count() == 1);
    CHECK(light.is_many(0));
}
} // namespace direct_light_test
