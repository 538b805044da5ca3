// SPDX-License-Identifier: GPL-3.0-or-later
// Whole light shafts against closed forms and against brute-force marching that knows nothing of intervals or pieces:
// it adds up, point by point, source * phase * transmittance to the camera * transmittance to the light * visibility.
#include "core/parallel.hpp"
#include "light_shafts/light_shafts.hpp"
#include "support/marched_shafts.hpp"
#include "support/soup.hpp"
#include "volume/phase_function.hpp"
#include <doctest/doctest.h>
#include <numbers>

namespace light_shafts_test {
using namespace tyndall;
using namespace tyndall::light_shafts;

using support::march;

namespace {
Medium fog(const Rgb& sigma_s, const Rgb& sigma_a, float g) {
    return {.name = "fog", .lobes = {{sigma_s, g}}, .sigma_a_per_m = sigma_a};
}
support::Part fog_box(const vec3& centre, const vec3& half_size, int medium = 0) {
    return {.mesh = support::cube(),
            .world_from_object = support::translation(centre) * glm::scale(mat4(1.0f), half_size),
            .material = {.name = "fog", .medium_index = medium, .has_surface = false}};
}
Light sun(const vec3& towards_light) {
    return {.name = "Sun",
            .kind = LightKind::Sun,
            .strength = Rgb(3.0f, 2.0f, 1.0f),
            .towards_light = glm::normalize(towards_light)};
}
Light lamp(const vec3& position) {
    return {.name = "Lamp", .kind = LightKind::Point, .strength = Rgb(30.0f, 20.0f, 10.0f), .position = position};
}
Result shafts(const Scene& scene, std::span<const ViewRay> rays, bool attenuates_light = true) {
    Progress progress;
    const View view{.position = rays[0].origin};
    return run(scene, view, rays, {.method = Method::Exact, .light_samples = 4, .attenuates_light = attenuates_light},
               progress);
}
double relative_difference(const Rgb& a, const Rgb& b) {
    return glm::length(glm::dvec3(a) - glm::dvec3(b)) / glm::length(glm::dvec3(b));
}
} // namespace

TEST_CASE("a sun straight above a slab has a closed form") {
    // At height z below the slab's top, light and camera lose exp(-sigma (top - z)) and exp(-sigma t).
    const float sigma_s = 0.05f, sigma_t = 0.08f, g = 0.4f;
    const auto scene = support::make_scene({fog_box({0, 0, 0}, {1000, 1000, 10})},
                                           {fog(Rgb(sigma_s), Rgb(sigma_t - sigma_s), g)}, {sun({0, 0, 1})});
    for (const float slope : {-0.9f, -0.3f, 0.0f, 0.3f, 0.9f}) {
        CAPTURE(slope);
        const vec3 direction(std::sqrt(1.0f - slope * slope), 0.0f, slope);
        const ViewRay ray{{0, 0, 1}, direction, 0.0f, 8.0f};
        const double per_m = sigma_t * (1.0 - slope); // the way to the camera grows, the way to the light shrinks
        const double integral = std::exp(-sigma_t * 9.0) * -std::expm1(-per_m * 8.0) / per_m;
        const Rgb expected = Rgb(3, 2, 1) * static_cast<float>(sigma_s * henyey_greenstein_per_sr(slope, g) * integral);
        CHECK(relative_difference(shafts(*scene, {&ray, 1}).radiance[0], expected) < 1e-5);
    }
}
TEST_CASE("without attenuation of the light, a lit ray scatters what its transmittance loses") {
    const auto scene =
        support::make_scene({fog_box({0, 0, 0}, {10, 10, 10})}, {fog(Rgb(0.1f), Rgb(0.0f), 0.0f)}, {sun({1, 2, 3})});
    const ViewRay ray{{0, 0, 0}, {0, 1, 0}, 0.0f, 100.0f};
    const float share = -std::expm1(-0.1f * 10.0f) / (4.0f * std::numbers::pi_v<float>);
    CHECK(relative_difference(shafts(*scene, {&ray, 1}, false).radiance[0], Rgb(3, 2, 1) * share) < 1e-6);
}
TEST_CASE("EXACT converges to brute-force marching in a soup, under a sun and a lamp, in two media that overlap") {
    std::vector<support::Part> parts = {
        {.mesh = support::soup_mesh(150, {.min = vec3(-8.0f), .max = vec3(8.0f)}, 2.5f, 21)},
        fog_box({0, 0, 0}, {9, 8, 7}, 0),
        fog_box({3, 2, 1}, {9, 4, 8}, 1),
    };
    const std::vector<Medium> media = {fog({0.05f, 0.04f, 0.02f}, {0.0f, 0.01f, 0.03f}, 0.6f),
                                       fog({0.01f, 0.03f, 0.06f}, {0.02f, 0.0f, 0.0f}, -0.3f)};
    support::SceneRandom random(5);
    for (const std::vector<Light>& lights :
         {std::vector<Light>{sun({0.4f, 0.3f, 0.8f})}, {lamp({2.0f, 1.0f, 3.0f})}, {lamp({-4.0f, 20.0f, 9.0f})}}) {
        CAPTURE(lights[0].position.x);
        const auto scene = support::make_scene(parts, media, lights);
        double worst = 0.0;
        for (int index = 0; index < 24; ++index) {
            const ViewRay ray{vec3(random.uniform(-6, 6), random.uniform(-6, 6), random.uniform(-6, 6)),
                              random.direction(), 0.0f, random.uniform(2.0f, 25.0f)};
            const Rgb ours = shafts(*scene, {&ray, 1}).radiance[0], marched = march(*scene, ray, 4000);
            worst = std::max(worst, relative_difference(ours, marched));
        }
        CHECK(worst <
              3e-3); // a shadow's edge moves by at most a step; a ray has some ten of them, at random: 10 / 4000
    }
}

namespace {
/// A wall in the plane x = 0 with a square hole of 2 m around (0, 0, 5): four panels.
std::vector<support::Part> wall_with_hole() {
    std::vector<support::Part> parts;
    const mat4 upright = glm::rotate(mat4(1.0f), 0.5f * std::numbers::pi_v<float>, vec3(0, 1, 0));
    for (const vec4& panel : {vec4(-51, 5, 50, 200), vec4(51, 5, 50, 200), vec4(0, 56, 1, 50), vec4(0, -46, 1, 50)})
        parts.push_back({.mesh = support::square(),
                         .world_from_object = support::translation({0, panel.x, panel.y}) * upright *
                                              glm::scale(mat4(1.0f), vec3(panel.w, panel.z, 1.0f))});
    return parts;
}
} // namespace
TEST_CASE("a beam through one opening is as wide as the opening, and fades with the way to the camera") {
    std::vector<support::Part> parts = wall_with_hole();
    parts.push_back(fog_box({25, 0, 5}, {30, 20, 20}));
    const float sigma_s = 0.03f, sigma_a = 0.02f, sigma_t = sigma_s + sigma_a;
    const auto scene = support::make_scene(parts, {fog(Rgb(sigma_s), Rgb(sigma_a), 0.0f)}, {sun({-1, 0, 0})});
    Rgb beams[2];
    for (const float away_m : {3.0f, 13.0f}) { // the beam is 10 m behind the wall, the camera beside it
        const ViewRay ray{{10, -1.0f - away_m, 5}, {0, 1, 0}, 0.0f, 2.0f * away_m};
        const Result result = shafts(*scene, {&ray, 1});
        const float way_in_fog_m = 15.0f; // from the fog's side at x = -5
        const float integral = std::exp(-sigma_t * away_m) * -std::expm1(-sigma_t * 2.0f) / sigma_t;
        const Rgb expected =
            Rgb(3, 2, 1) * (sigma_s / (4.0f * std::numbers::pi_v<float>)*std::exp(-sigma_t * way_in_fog_m) * integral);
        CHECK(relative_difference(result.radiance[0], expected) < 1e-5);
        CHECK(std::abs(result.average_visibility[0] - 1.0f / away_m) < 1e-5f);
        beams[away_m > 5.0f] = result.radiance[0];
    }
    // Eq. 5.2 sees the two beams' radiance only through the average visibility: it would be wrong by 40 % here.
    CHECK(std::abs(beams[1].x / beams[0].x / std::exp(-sigma_t * 10.0f) - 1.0f) < 1e-5f);
}
TEST_CASE("the same beam near or far on the ray has the same average visibility: eq. 5.2 cannot tell, 5.1 must") {
    std::vector<support::Part> parts = wall_with_hole();
    parts.push_back(fog_box({25, 0, 5}, {30, 30, 20}));
    const float sigma_t = 0.3f;
    const auto scene = support::make_scene(parts, {fog(Rgb(sigma_t), Rgb(0.0f), 0.0f)}, {sun({-1, 0, 0})});
    const ViewRay near{{10, -2, 5}, {0, 1, 0}, 0.0f, 20.0f}, far{{10, -12, 5}, {0, 1, 0}, 0.0f, 20.0f};
    const Result a = shafts(*scene, {&near, 1}), b = shafts(*scene, {&far, 1});
    CHECK(std::abs(a.average_visibility[0] - b.average_visibility[0]) < 1e-6f);
    CHECK(std::abs(b.radiance[0].x / a.radiance[0].x / std::exp(-sigma_t * 10.0f) - 1.0f) < 1e-5f);
}
TEST_CASE("a lamp in an endless medium shows the airlight of Sun et al. 2005") {
    // Eq. 9 and 10 there: A0 [F(A1, pi/4 + atan((Tvp - Tsv cos g) / (Tsv sin g)) / 2) - F(A1, g / 2)], with
    // F(u, v) = integral from 0 to v of exp(-u tan x); beta both scatters and extinguishes, the phase is 1 / (4 pi).
    const double beta = 0.05, distance_m = 6.0, far_m = 30.0;
    const auto special = [](double u, double v) {
        constexpr int steps = 200000;
        double sum = 0.0;
        for (int step = 0; step < steps; ++step)
            sum += std::exp(-u * std::tan(v * (step + 0.5) / steps));
        return sum * v / steps;
    };
    SceneDescription description;
    description.media = {fog(Rgb(static_cast<float>(beta)), Rgb(0.0f), 0.0f)};
    description.world_medium_index = 0;
    description.lights = {lamp({0, 0, 0})};
    const Scene scene(std::move(description), Progress());
    for (const double gamma : {0.01, 0.3, 1.2, 2.0, 3.0}) { // between the ray and the way to the lamp
        CAPTURE(gamma);
        const double tsv = beta * distance_m, tvp = beta * far_m;
        const double a0 =
            beta * beta * 30.0 * std::exp(-tsv * std::cos(gamma)) / (2.0 * std::numbers::pi * tsv * std::sin(gamma));
        const double a1 = tsv * std::sin(gamma);
        const double end =
            0.25 * std::numbers::pi + 0.5 * std::atan((tvp - tsv * std::cos(gamma)) / (tsv * std::sin(gamma)));
        const double expected = a0 * (special(a1, end) - special(a1, 0.5 * gamma));
        const ViewRay ray{{0, 0, -static_cast<float>(distance_m)},
                          {static_cast<float>(std::sin(gamma)), 0, static_cast<float>(std::cos(gamma))},
                          0.0f,
                          static_cast<float>(far_m)};
        CHECK(std::abs(shafts(scene, {&ray, 1}).radiance[0].x / expected - 1.0) < 2e-5);
    }
}
TEST_CASE("a ray at the lamp itself stays finite, and grows towards it") {
    const auto scene =
        support::make_scene({fog_box({0, 0, 0}, {10, 10, 10})}, {fog(Rgb(0.1f), Rgb(0.0f), 0.9f)}, {lamp({0, 0, 0})});
    float before = 0.0f;
    for (const float offset_m : {1.0f, 0.1f, 1e-2f, 1e-4f, 0.0f}) {
        const ViewRay ray{{offset_m, 0, -5}, {0, 0, 1}, 0.0f, 10.0f};
        const float radiance = shafts(*scene, {&ray, 1}).radiance[0].x;
        CHECK(std::isfinite(radiance));
        CHECK(radiance > before);
        before = radiance;
    }
}
TEST_CASE("spots: cones with soft edges agree with marching, inside and outside of the fog") {
    Light spot = lamp({0, 0, 6});
    spot.kind = LightKind::Spot, spot.name = "Spot";
    spot.spot_axis = glm::normalize(vec3(0.2f, 0.1f, -1.0f));
    spot.spot_half_angle_rad = 0.5f, spot.spot_blend = 0.3f;
    support::SceneRandom random(7);
    for (const SpotFalloff falloff : {SpotFalloff::Blender3, SpotFalloff::Blender4}) {
        spot.spot_falloff = falloff;
        // Blender 4 looks at the cone in the lamp's own space, along -Z.
        const auto [tangent, bitangent] = orthonormal_basis(-spot.spot_axis);
        spot.light_from_world_directions = glm::transpose(mat3(tangent, bitangent, -spot.spot_axis));
        for (const float half_m : {10.0f, 4.0f}) {
            const auto scene = support::make_scene({fog_box({0, 0, 0}, vec3(half_m))},
                                                   {fog({0.1f, 0.05f, 0.02f}, Rgb(0.01f), 0.5f)}, {spot});
            for (int index = 0; index < 16; ++index) {
                const ViewRay ray{3.0f * vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)),
                                  random.direction(), 0.0f, 6.0f};
                const Rgb ours = shafts(*scene, {&ray, 1}).radiance[0], marched = march(*scene, ray, 4000);
                CHECK(glm::length(ours - marched) <= 1e-3f * glm::length(marched) + 1e-7f);
            }
        }
    }
}
TEST_CASE("from clear air to soot: radiance stays finite and follows the density") {
    for (const float sigma : {1e-9f, 1e-6f, 1e-3f, 1.0f, 1e3f})
        for (const Light& light : {sun({0.3f, 0.2f, 1.0f}), lamp({2, 3, 4})}) {
            CAPTURE(sigma);
            CAPTURE(light.name);
            const auto scene =
                support::make_scene({fog_box({0, 0, 0}, {10, 10, 10})}, {fog(Rgb(sigma), Rgb(0.0f), 0.2f)}, {light});
            const ViewRay ray{{0.5f, 0.2f, 9.9f}, {1, 0, 0}, 0.0f, 5.0f};
            const Rgb radiance = shafts(*scene, {&ray, 1}).radiance[0];
            CHECK(std::isfinite(radiance.x));
            CHECK(radiance.x >= 0.0f);
            if (sigma <= 1e-3f) { // thin: twice the density, twice the light
                const auto denser = support::make_scene({fog_box({0, 0, 0}, {10, 10, 10})},
                                                        {fog(Rgb(2.0f * sigma), Rgb(0.0f), 0.2f)}, {light});
                CHECK(std::abs(shafts(*denser, {&ray, 1}).radiance[0].x / radiance.x - 2.0f) < 40.0f * sigma + 1e-5f);
            }
        }
}
TEST_CASE("a frame's bits do not depend on the number of threads") {
    const auto scene = support::make_scene(
        {{support::soup_mesh(200, {.min = vec3(-8.0f), .max = vec3(8.0f)}, 2.0f, 3)}, fog_box({0, 0, 0}, {9, 9, 9})},
        {fog(Rgb(0.1f), Rgb(0.0f), 0.3f)}, {sun({1, 2, 3}), lamp({1, 0, 2})});
    support::SceneRandom random(3);
    std::vector<ViewRay> rays;
    for (int ray = 0; ray < 3000; ++ray)
        rays.push_back({{0, 0, 0}, random.direction(), 0.0f, 20.0f});
    const auto with = [&](int threads) { return with_threads(threads, [&] { return shafts(*scene, rays).radiance; }); };
    CHECK(with(1) == with(4));
}
TEST_CASE("what cannot scatter is skipped, and the statistics say why") {
    const ViewRay ray{{0, 0, 0}, {1, 0, 0}, 0.0f, 5.0f};
    const auto skipped = [&](const Scene& scene) {
        const Result result = shafts(scene, {&ray, 1});
        CHECK(result.radiance[0] == Rgb(0.0f));
        return result.statistics.skipped.empty() ? std::string() : result.statistics.skipped.front().reason;
    };
    CHECK(skipped(*support::make_scene({}, {}, {lamp({0, 0, 1})})) == "no medium in the scene");
    Light off = lamp({0, 0, 1});
    off.scatters_in_media = false;
    CHECK(skipped(*support::make_scene({fog_box({0, 0, 0}, vec3(3))}, {fog(Rgb(1), Rgb(0), 0)}, {off})) ==
          "switched off");
    Light spot = lamp({0, 0, 9});
    spot.kind = LightKind::Spot, spot.spot_axis = {0, 0, 1}, spot.spot_falloff = SpotFalloff::Blender3;
    CHECK(skipped(*support::make_scene({fog_box({0, 0, 0}, vec3(3))}, {fog(Rgb(1), Rgb(0), 0)}, {spot})) ==
          "its cone does not reach a medium");
}
} // namespace light_shafts_test
