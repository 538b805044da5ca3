// SPDX-License-Identifier: GPL-3.0-or-later
// Air around lamps that are spheres, and within them, against marching with directions that each point of a ray samples.
#include "core/parallel.hpp"
#include "core/sampling.hpp"
#include "light_shafts/light_shafts.hpp"
#include "support/forest.hpp"
#include "support/scenes.hpp"
#include <doctest/doctest.h>
#include <numeric>

namespace sphere_shafts_test {
using namespace tyndall;
using namespace tyndall::light_shafts;

namespace {
constexpr float sigma_s_per_m = 0.05f, half_box_m = 3.0f;

Light lamp(LightKind kind, float radius_m) {
    Light light{.name = "Lamp", .kind = kind, .position = {0.2f, -0.1f, 0.3f}};
    light.radius_m = radius_m;
    light.spot_axis = glm::normalize(vec3(0.3f, 0.2f, -1.0f));
    light.spot_half_angle_rad = 0.9f, light.spot_blend = 0.2f;
    const auto [x, y] = orthonormal_basis(-light.spot_axis);
    light.light_from_world_directions = glm::transpose(mat3(x, y, -light.spot_axis));
    return light;
}
std::unique_ptr<Scene> scene_of(const Light& light, float asymmetry_g) {
    return support::make_scene({{.mesh = support::cube(),
                                 .world_from_object = glm::scale(mat4(1.0f), vec3(half_box_m)),
                                 .material = {.name = "fog", .medium_index = 0, .has_surface = false}}},
                               {{.name = "fog", .lobes = {{Rgb(sigma_s_per_m), asymmetry_g}}}}, {light});
}
std::vector<ViewRay> rays_past(const Light& light, int count) {
    support::SceneRandom random(8);
    const vec3 eye(2.4f, -0.5f, 0.7f);
    std::vector<ViewRay> rays;
    for (int index = 0; index < count; ++index) {
        const float aside_m = 2.0f * light.radius_m * std::sqrt(random.uniform());
        rays.push_back({eye, glm::normalize(light.position + aside_m * random.direction() - eye), 0.0f, 9.0f});
    }
    return rays;
}
double march(const Light& light, const ViewRay& ray, int steps, support::SceneRandom& random, double g) {
    const double step_m = double{ray.far_m} / steps, radius_m = light.radius_m;
    const double radiance = double{light.strength.x} / (std::numbers::pi * radius_m * radius_m);
    double sum = 0.0;
    for (int step = 0; step < steps; ++step) {
        const auto t = static_cast<float>((step + double{random.uniform()}) * step_m);
        const vec3 point = ray.origin + t * ray.direction, from_middle = point - light.position;
        if (glm::any(glm::greaterThan(glm::abs(point), vec3(half_box_m))))
            continue;
        if (glm::length(from_middle) < light.radius_m) { // all directions; a phase function's integral is 1
            sum += radiance *
                   std::exp(-sigma_s_per_m * (t + radius_m - 0.5 * glm::dot(from_middle, from_middle) / radius_m));
            continue;
        }
        const LightSample sample = sample_light_towards(light, 0, {random.uniform(), random.uniform()}, point);
        const vec3 way = point - sample.position, from_light = glm::normalize(way);
        const double cosine = -glm::dot(from_light, ray.direction), distance_m = glm::length(way);
        const double phase = (1.0 - g * g) / (4.0 * std::numbers::pi * std::pow(1.0 + g * g - 2.0 * g * cosine, 1.5));
        sum += double{intensity_w_per_sr(sample, from_light).x} / (distance_m * distance_m) * phase *
               std::exp(-sigma_s_per_m * (t + distance_m));
    }
    return sum * step_m * sigma_s_per_m;
}
double mean(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}
} // namespace

// Softened by their size alone, patches of a sphere light the air next to it with a third of what the lamp sends there.
TEST_CASE("the air around a lamp that is a sphere, and within it, gets what the lamp sends, with few samples") {
    for (const LightKind kind : {LightKind::Point, LightKind::Spot})
        for (const float asymmetry_g : {0.0f, 0.7f}) {
            CAPTURE(static_cast<int>(kind));
            CAPTURE(asymmetry_g);
            const Light light = lamp(kind, 0.5f);
            const auto scene = scene_of(light, asymmetry_g);
            const std::vector<ViewRay> rays = rays_past(light, 64);
            std::vector<double> marched(rays.size()), ours;
            const Progress progress;
            parallel_for(
                rays.size(), progress,
                [&](std::size_t ray) {
                    support::SceneRandom random(100 + ray);
                    marched[ray] = march(light, rays[ray], 40'000, random, asymmetry_g);
                },
                1);
            for (std::uint32_t seed = 0; seed < 4; ++seed) {
                Progress running;
                const Config config{.method = Method::Exact, .light_samples = 64, .adapts_strata = false, .seed = seed};
                for (const Rgb& radiance : run(*scene, {.position = rays[0].origin}, rays, config, running).radiance)
                    ours.push_back(radiance.x);
            }
            // A cone's edge is where it is, for points that are lifted off the lamp, too.
            CHECK(std::abs(mean(ours) / mean(marched) - 1.0) < (kind == LightKind::Spot ? 0.02 : 0.008));
        }
}
} // namespace sphere_shafts_test
