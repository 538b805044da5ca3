// SPDX-License-Identifier: GPL-3.0-or-later
// What media scatter into rays that surfaces send on is, in the mean, what EXACT finds for a camera's ray.
#include "render/sent_air.hpp"
#include "support/fog_draws.hpp"
#include "support/one_point.hpp"
#include <doctest/doctest.h>

namespace sent_air_test {
using namespace tyndall;
using namespace tyndall::support;
using render::FogGlow;
using render::MeshEmitters;
using render::SentAir;

namespace {
/// Fog in a box, and another that scatters mostly onwards within it, around a post and under a roof.
std::unique_ptr<Scene> stage(std::vector<Light> lights, const Rgb& world = Rgb(0.0f)) {
    Part post{.mesh = cube(), .world_from_object = glm::scale(translation({0.3f, 0.9f, 0}), vec3(0.2f, 0.2f, 2))};
    Part roof{.mesh = square(), .world_from_object = glm::scale(translation({-1, 0, 2.5f}), vec3(1, 1, 1))};
    std::vector<Medium> media{{.name = "fog", .lobes = {{Rgb(0.1f, 0.2f, 0.3f), 0.0f}}, .sigma_a_per_m = Rgb(0.02f)},
                              {.name = "onwards", .lobes = {{Rgb(0.4f), 0.7f}}, .sigma_a_per_m = Rgb(0.0f)}};
    return in_world({post, roof, box_of(0, vec3(0.0f), vec3(3, 2, 2)), box_of(1, vec3(1, 0, 0), vec3(0.7f))}, world,
                    std::move(lights), std::move(media));
}
Light lamp(LightKind kind, const vec3& position, const Rgb& strength) {
    Light light{.name = "lamp", .kind = kind, .strength = strength, .position = position};
    light.spot_axis = glm::normalize(-position);
    return light;
}
constexpr light_shafts::ViewRay across{vec3(-4, -0.3f, 0.2f), vec3(1, 0, 0), 0.5f, 9.0f};

void check_is_that_of_exact(const Scene& scene) {
    const Media media(scene, Progress());
    light_shafts::Config config{.method = light_shafts::Method::Exact, .light_samples = 1024, .world_samples = 4096};
    Progress progress;
    const Rgb truth = light_shafts::run(scene, {.position = across.origin}, {&across, 1}, config, progress).radiance[0];
    const MeshEmitters emitters(scene);
    const SentAir air(scene, media, emitters, {});
    REQUIRE(!air.is_empty());
    const auto [mean, sigma] =
        mean_of_draws(256, [&](const FogGlow::Numbers& numbers, std::vector<FogGlow::Found>& found) {
            air.draw(across, numbers, found);
        });
    for (int channel = 0; channel < 3; ++channel) {
        CAPTURE(mean[channel] / truth[channel] - 1.0);
        CAPTURE(sigma[channel] / truth[channel]);
        CHECK(sigma[channel] < 0.01 * truth[channel]);
        CHECK(std::abs(mean[channel] - truth[channel]) < 4.0 * sigma[channel] + 2e-3 * truth[channel]); // of strata
    }
}
} // namespace

TEST_CASE("lamps of every kind light the air of a ray as EXACT says, with shadows") {
    Light point = lamp(LightKind::Point, {0.5f, 1.8f, 0.5f}, Rgb(3, 2, 1));
    Light ball = lamp(LightKind::Point, {-2, 1, 1.5f}, Rgb(2.0f));
    ball.radius_m = 0.3f;
    Light disc = ball;
    disc.body = LightBody::FacingDisc;
    Light spot = lamp(LightKind::Spot, {0, 3, 2}, Rgb(30, 20, 10));
    spot.spot_half_angle_rad = 0.3f, spot.spot_blend = 0.4f, spot.spot_falloff = SpotFalloff::Blender3;
    Light area = lamp(LightKind::Area, {0, 2.5f, 1}, Rgb(5.0f));
    area.half_size_m = {0.6f, 0.3f};
    area.spot_half_angle_rad = 1.2f;
    for (const auto& lights : {std::vector{point}, {ball}, {disc}, {spot}, {area}, {point, ball, spot, area}}) {
        CAPTURE(static_cast<int>(lights[0].kind));
        check_is_that_of_exact(*stage(lights));
    }
}
// Seen to fail: with a sphere that shines outwards alone (EXACT), and with its centre in place of it (draws).
TEST_CASE("air in a lamp that is a sphere is lit from all around by its surface, and so in draws") {
    Light ball = lamp(LightKind::Point, vec3(0.5f, -0.2f, 0.3f), Rgb(2, 1, 0.5f));
    ball.radius_m = 0.3f;
    const auto check_through = [&](const Medium& fog, const light_shafts::ViewRay& ray, const dvec3& truth) {
        const auto scene = in_world({box_of(0, vec3(0.0f), vec3(2.0f))}, Rgb(0.0f), {ball}, {fog});
        const Media media(*scene, Progress());
        Progress progress;
        const light_shafts::Config config{.method = light_shafts::Method::Exact, .light_samples = 16384};
        const dvec3 exact(light_shafts::run(*scene, {.position = ray.origin}, {&ray, 1}, config, progress).radiance[0]);
        const MeshEmitters emitters(*scene);
        const SentAir air(*scene, media, emitters, {});
        const auto [mean, sigma] =
            mean_of_draws(256, [&](const FogGlow::Numbers& numbers, std::vector<FogGlow::Found>& found) {
                air.draw(ray, numbers, found);
            });
        for (int channel = 0; channel < 3; ++channel) {
            CAPTURE(exact[channel] / truth[channel] - 1.0);
            CAPTURE(mean[channel] / truth[channel] - 1.0);
            CHECK(std::abs(exact[channel] / truth[channel] - 1.0) < 0.02); // strata are blurred at the surface
            CHECK(std::abs(mean[channel] - truth[channel]) < 4.0 * sigma[channel] + 2e-3 * truth[channel]);
            CHECK(sigma[channel] < 0.01 * truth[channel]);
        }
    };
    // Through the centre, in thin air: 4 pi of the surface's radiance within, outside what of the sphere is in sight.
    const light_shafts::ViewRay through{vec3(-4, -0.2f, 0.3f), vec3(1, 0, 0), 0.5f, 9.0f};
    const double radius_m = 0.3, sigma_s = 1e-4;
    double sum = 4.0 * pi * 2.0 * radius_m;
    constexpr int steps = 100'000;
    for (const double far_m : {1.5, 2.5})
        for (int step = 0; step < steps; ++step) {
            const double at_m = radius_m + (far_m - radius_m) * (step + 0.5) / steps;
            sum += 2.0 * pi * (1.0 - std::sqrt(1.0 - radius_m * radius_m / (at_m * at_m))) * (far_m - radius_m) / steps;
        }
    const dvec3 surface = dvec3(ball.strength) / (pi * radius_m * radius_m);
    check_through({.name = "fog", .lobes = {{Rgb(float(sigma_s)), 0.0f}}}, through,
                  sigma_s / (4.0 * pi) * sum * surface);
    // A chord within, in thin air that scatters onwards; and in dense air, which dims the light on its way.
    const light_shafts::ViewRay chord{vec3(0.5f, -0.05f, 0.3f), vec3(0, 0, 1), 0.0f, 0.2f};
    check_through({.name = "fog", .lobes = {{Rgb(float(sigma_s)), 0.6f}}}, chord, sigma_s * 0.2 * surface);
    constexpr int count = 200;
    dvec3 within(0.0);
    for (int place = 0; place < count; ++place) {
        const double height_m = 0.2 * (place + 0.5) / count, off2 = 0.15 * 0.15 + height_m * height_m;
        double arriving = 0.0; // of the surface's radiance
        for (int ring = 0; ring < count; ++ring) {
            const double along_m = std::sqrt(off2) * (2.0 * (ring + 0.5) / count - 1.0);
            arriving += std::exp(-0.5 * (std::sqrt(along_m * along_m + radius_m * radius_m - off2) - along_m)) / count;
        }
        within += std::exp(-0.5 * height_m) * 0.3 * arriving * 0.2 / count * surface;
    }
    check_through({.name = "fog", .lobes = {{Rgb(0.3f), 0.0f}}, .sigma_a_per_m = Rgb(0.2f)}, chord, within);
}
TEST_CASE("suns and the world's light scatter into a ray as EXACT says") {
    Light sun{.name = "sun", .kind = LightKind::Sun, .strength = Rgb(2, 1, 0.5f)};
    sun.towards_light = glm::normalize(vec3(0.2f, 1, 0.6f));
    sun.half_angle_rad = 0.1f;
    Light weak = sun;
    weak.strength = Rgb(0.1f), weak.towards_light = glm::normalize(vec3(-1, 0.3f, 0.2f)), weak.half_angle_rad = 0.0f;
    check_is_that_of_exact(*stage({sun}));
    check_is_that_of_exact(*stage({weak, sun}));
    check_is_that_of_exact(*stage({}, Rgb(0.4f, 0.6f, 0.9f)));
    check_is_that_of_exact(*stage({sun, lamp(LightKind::Point, {0.5f, 1.8f, 0.5f}, Rgb(3, 2, 1))}, Rgb(0.1f)));
}
TEST_CASE("lights that do not scatter leave the air of sent rays dark") {
    Light silent = lamp(LightKind::Point, {0, 1, 0}, Rgb(1.0f));
    silent.scatters_in_media = false;
    const auto scene = stage({silent}, Rgb(1.0f));
    const Media media(*scene, Progress());
    CHECK(SentAir(*scene, media, MeshEmitters(*scene), {.world_scatters = false}).is_empty());
}
} // namespace sent_air_test
