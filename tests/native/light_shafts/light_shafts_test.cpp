// SPDX-License-Identifier: GPL-3.0-or-later
// Whole light shafts against closed forms and against brute-force marching that knows nothing of intervals or pieces:
// it adds up, point by point, source * phase * transmittance to the camera * transmittance to the light * visibility.
#include "light_shafts/light_shafts.hpp"
#include "support/soup.hpp"
#include "volume/phase_function.hpp"
#include <doctest/doctest.h>
#include <numbers>

using namespace tyndall;
using namespace tyndall::light_shafts;

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

/// Midpoint rule over the ray, each point asked alone. Lights without a size.
Rgb march(const Scene& scene, const ViewRay& ray, int steps, bool attenuates_light = true) {
    Progress progress;
    const Media media(scene, progress);
    const double step_m = (double{ray.far_m} - ray.near_m) / steps;
    glm::dvec3 sum(0.0);
    for (int step = 0; step < steps; ++step) {
        const auto t = static_cast<float>(ray.near_m + (step + 0.5) * step_m);
        const vec3 point = ray.origin + t * ray.direction;
        std::vector<MediumSegment> here;
        media.segments({.origin = point, .direction = ray.direction, .far_m = 1e-3f}, here);
        if (here.empty())
            continue;
        const Rgb to_camera =
            media.transmittance({.origin = ray.origin, .direction = ray.direction, .near_m = ray.near_m, .far_m = t});
        for (std::uint32_t index = 0; index < scene.lights().size(); ++index) {
            const LightSample light = sample_light(scene.lights()[index], index, vec2(0.5f));
            Ray to_light{.origin = point, .direction = light.towards_light};
            Rgb irradiance = light.strength;
            if (!light.is_directional) {
                const vec3 way = light.position - point;
                to_light.far_m = glm::length(way);
                to_light.direction = way / to_light.far_m;
                irradiance = intensity_w_per_sr(light, -to_light.direction) / (to_light.far_m * to_light.far_m);
            }
            const Rgb phase = media.scatter_per_m_sr(here[0].set, glm::dot(ray.direction, to_light.direction));
            const Rgb to_the_light = attenuates_light ? media.transmittance(to_light) : Rgb(1.0f);
            sum += glm::dvec3(irradiance * phase * to_camera * to_the_light * scene.shadow_transmittance(to_light));
        }
    }
    return Rgb(sum * step_m);
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
