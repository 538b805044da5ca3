// SPDX-License-Identifier: GPL-3.0-or-later
// The world's light on a point by one strategy at a time: whichever is drawn, the mean is the integral over the hemisphere.
#include "core/sampling.hpp"
#include "render/direct_light.hpp"
#include "render/lamp_hits.hpp"
#include "scene/media.hpp"
#include "support/environment_images.hpp"
#include "support/scenes.hpp"
#include <doctest/doctest.h>
#include <numbers>

namespace world_lobes_test {
using namespace tyndall;
using namespace tyndall::support;

namespace {

World patchy_world() {
    std::vector<Rgb> colours;
    for (std::uint32_t texel = 0; texel < 32 * 16; ++texel)
        colours.push_back(Rgb(0.2f + unit_float(hash(texel)), 0.5f, unit_float(hash(texel, 1u))));
    colours[12 * 32 + 9] = Rgb(60.0f, 40.0f, 20.0f);
    return World("sky", Rgb(1.0f), support::environment_image(32, 16, colours));
}
Lobe facets(float alpha, float share) {
    return {.kind = Lobe::Kind::Ggx, .alpha = alpha, .sampling = share, .weight = Rgb(share)};
}
/// Of irradiance, and of what lobes reflect.
struct Found {
    glm::dvec3 irradiance{0.0}, reflected{0.0};
};
Found by_quadrature(const World& world, const LobeSet& lobes) {
    constexpr int rings = 600, sectors = 1200;
    Found sum;
    for (int ring = 0; ring < rings; ++ring)
        for (int sector = 0; sector < sectors; ++sector) {
            const double cosine = std::sqrt((ring + 0.5) / rings), sine = std::sqrt(1.0 - cosine * cosine);
            const double azimuth = 2.0 * std::numbers::pi * (sector + 0.5) / sectors;
            const vec3 direction(sine * std::cos(azimuth), sine * std::sin(azimuth), cosine);
            const Rgb radiance = world.radiance(direction);
            sum.irradiance += glm::dvec3(radiance);
            sum.reflected += glm::dvec3(radiance * lobes.per_irradiance(direction));
        }
    const double weight = std::numbers::pi / (double{rings} * sectors);
    return {sum.irradiance * weight, sum.reflected * weight};
}
} // namespace

// Seen to fail with the lobes' share of the density left out.
TEST_CASE(
    "what the world sends to a glossy point is its integral, whatever share lobes have and however sharp they are") {
    for (const World& world : {patchy_world(), World("even", Rgb(0.7f))})
        for (const float lambert_share : {0.0f, 0.5f})
            for (const float alpha : {0.05f, 0.5f}) {
                CAPTURE(world.has_image());
                CAPTURE(lambert_share);
                CAPTURE(alpha);
                SceneDescription description = description_of(*make_scene({{.mesh = square()}}));
                description.world = world;
                const Scene scene(std::move(description), Progress());
                const Media media(scene, Progress());
                Statistics statistics;
                const render::DirectLight light(scene, media, statistics);
                const Ray down{.origin = {0.3f, 0.2f, 5.0f}, .direction = {0, 0, -1}};
                render::SurfacePoint point = render::surface_point(scene, down, scene.closest_hit(down), 0);
                point.lambert_share = lambert_share;
                const std::array lobe{facets(alpha, 0.3f)};
                render::DirectLight::PointLobes lobes{};
                lobes[0] = {.lobes = lobe, .normal = {0, 0, 1}, .outgoing = glm::normalize(vec3(0.5f, 0.2f, 1.0f))};
                Found sum, squares;
                constexpr std::uint32_t run_count = 16, sample_count = 1024;
                constexpr std::array<std::uint8_t, 1> only_light{1};
                for (std::uint32_t run = 0; run < run_count; ++run) {
                    point.pixel_seed = hash(run, 3u);
                    Found mean;
                    for (std::uint32_t sample = 0; sample < sample_count; ++sample) {
                        render::DirectLight::Irradiance found;
                        light.at({&point, 1}, {sample, 0}, only_light, {&found, 1}, &lobes);
                        mean.irradiance += glm::dvec3(found.from_world) / double{sample_count};
                        mean.reflected += glm::dvec3(found.reflected) / double{sample_count};
                    }
                    sum.irradiance += mean.irradiance, sum.reflected += mean.reflected;
                    squares.irradiance += mean.irradiance * mean.irradiance;
                    squares.reflected += mean.reflected * mean.reflected;
                }
                const Found truth = by_quadrature(scene.world(), lobes[0]);
                const auto check = [&](const glm::dvec3& total, const glm::dvec3& of_squares, const glm::dvec3& right) {
                    for (int channel = 0; channel < 3; ++channel) {
                        const double mean = total[channel] / run_count;
                        const double sigma =
                            std::sqrt(std::max(of_squares[channel] / run_count - mean * mean, 0.0) / (run_count - 1));
                        CHECK(sigma < 0.01 * right[channel]);
                        CHECK(std::abs(mean - right[channel]) < 4.0 * sigma + 2e-3 * right[channel]);
                    }
                };
                check(sum.irradiance, squares.irradiance, truth.irradiance);
                check(sum.reflected, squares.reflected, truth.reflected);
            }
}

// Seen to fail with a tenth of the bound.
TEST_CASE(
    "where lobes are said to find nothing of a lamp, their density is nowhere on it a fair share of the aimed rays'") {
    int left_out = 0;
    for (std::uint32_t index = 0; index < 400; ++index) {
        const vec2 u = sobol_point(index, 1u), v = sobol_point(index, 2u), w = sobol_point(index, 3u);
        Light lamp;
        lamp.name = "Lamp";
        lamp.strength = Rgb(1.0f);
        lamp.kind = index % 2 == 0 ? LightKind::Point : LightKind::Sun;
        lamp.position = 4.0f * sample_cosine_hemisphere(u) + vec3(0, 0, 0.1f);
        lamp.radius_m = 0.02f + 0.5f * v.x * v.x;
        lamp.towards_light = sample_cosine_hemisphere(u);
        lamp.half_angle_rad = 0.01f + 0.3f * v.x * v.x;
        const render::LightAim aim(lamp);
        const std::array lobe{facets(0.02f + 0.9f * v.y * v.y, 0.5f)};
        const LobeSet lobes{.lobes = lobe, .normal = {0, 0, 1}, .outgoing = sample_cosine_hemisphere(w)};
        if (render::lobes_may_find(aim.form(), vec3(0.0f), render::most_pdf_per_sr(lobes)))
            continue;
        ++left_out;
        for (std::uint32_t around = 0; around < 64; ++around) {
            const vec3 axis = lamp.kind == LightKind::Sun ? lamp.towards_light : glm::normalize(lamp.position);
            const vec3 direction = from_frame(axis, sample_uniform_cone(sobol_point(around, 4u), 0.05f));
            if (const render::LampHit hit = render::lamp_hit(aim.form(), vec3(0.0f), direction);
                hit.pdf_per_sr > 0.0f && direction.z > 0.0f)
                CHECK(lobes.pdf_per_sr(direction) <= 0.11f * hit.pdf_per_sr);
        }
    }
    CHECK(left_out > 40);
    CHECK(left_out < 380);
}
} // namespace world_lobes_test
