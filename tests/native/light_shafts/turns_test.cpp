// SPDX-License-Identifier: GPL-3.0-or-later
// The strata of a light with a size are dealt out to the samples of a pixel: no pass pays for all, together they have all.
#include "light_shafts/light_shafts.hpp"
#include "support/scenes.hpp"
#include <cmath>
#include <doctest/doctest.h>

using namespace tyndall;
using namespace tyndall::support;

TEST_CASE("the mean over all turns is the light of all strata, whatever both numbers are") {
    Material fog{.name = "fog"};
    fog.has_surface = false;
    fog.medium_index = 0;
    const Medium medium{.name = "fog", .lobes = {{.sigma_s_per_m = {0.1f, 0.2f, 0.3f}, .asymmetry_g = 0.5f}}};
    Light lamp;
    lamp.name = "Lamp";
    lamp.kind = LightKind::Point;
    lamp.position = {0.3f, 0.2f, 3.0f};
    lamp.radius_m = 0.5f;
    const auto scene =
        make_scene({{.mesh = cube(), .material = fog}, // a blocker under the lamp makes every stratum another picture
                    {.mesh = square(), .world_from_object = glm::scale(translation({0.2f, 0, 1.5f}), vec3(0.4f))}},
                   {medium}, {lamp});
    Progress progress;
    const Media media(*scene, progress);
    light_shafts::Config config;
    config.method = light_shafts::Method::Exact;
    config.light_samples = 7;
    const light_shafts::View view{.is_orthographic = false, .position = {0, -4, 0}};
    std::vector<light_shafts::ViewRay> rays;
    for (const float x : {-0.15f, 0.0f, 0.1f})
        rays.push_back({view.position, glm::normalize(vec3(x, 1, 0.05f)), 0.0f, 10.0f});
    const light_shafts::Shafts shafts(*scene, media, view, rays, config, progress);
    std::vector<Rgb> truth(rays.size());
    std::vector<float> true_visibility(rays.size());
    shafts.scatter(rays, truth, true_visibility, progress);
    for (const std::uint32_t count : {1u, 2u, 3u, 6u, 7u, 8u, 14u, 17u}) {
        CAPTURE(count);
        std::vector<glm::dvec3> sum(rays.size(), glm::dvec3(0.0));
        std::vector<double> visibility_sum(rays.size());
        for (std::uint32_t index = 0; index < count; ++index) {
            std::vector<Rgb> radiance(rays.size());
            std::vector<float> visibility(rays.size());
            shafts.scatter(rays, radiance, visibility, progress, {index, count});
            for (std::size_t ray = 0; ray < rays.size(); ++ray) {
                sum[ray] += glm::dvec3(radiance[ray]) / double(count);
                visibility_sum[ray] += visibility[ray] / double(count);
            }
        }
        for (std::size_t ray = 0; ray < rays.size(); ++ray) {
            CHECK(glm::length(sum[ray] - glm::dvec3(truth[ray])) < 1e-6 * glm::length(glm::dvec3(truth[ray])));
            CHECK(std::abs(visibility_sum[ray] - true_visibility[ray]) < 1e-6);
        }
    }
    std::vector<Rgb> radiance(rays.size());
    CHECK_THROWS_AS(shafts.scatter(rays, radiance, {}, progress, {3, 3}), InvalidInput);
}
