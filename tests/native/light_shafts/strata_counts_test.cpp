// SPDX-License-Identifier: GPL-3.0-or-later
// As many strata as an error target asks for: enough for its error, and not many more.
#include "light_shafts/strata_counts.hpp"
#include "support/scenes.hpp"
#include <cmath>
#include <doctest/doctest.h>

namespace strata_counts_test {
using namespace tyndall;
using namespace tyndall::support;

/// A lamp over a row of slats in fog, seen from the side: nothing but penumbrae.
static std::unique_ptr<Scene> slats_under_a_lamp(float radius_m) {
    Material fog{.name = "fog"};
    fog.has_surface = false;
    fog.medium_index = 0;
    const Medium medium{.name = "fog", .lobes = {{.sigma_s_per_m = Rgb(0.2f)}}};
    Light lamp;
    lamp.name = "Lamp";
    lamp.kind = LightKind::Point;
    lamp.position = {0.1f, 0.2f, 3.0f};
    lamp.radius_m = radius_m;
    std::vector<Part> parts{{.mesh = cube(), .material = fog}};
    for (int slat = -4; slat <= 4; ++slat)
        parts.push_back(
            {.mesh = square(),
             .world_from_object = glm::scale(translation({0.25f * float(slat), 0, 1.5f}), vec3(0.06f, 2, 1))});
    return make_scene(parts, {medium}, {lamp});
}

TEST_CASE("the strata that an error target asks for keep it, and a smaller lamp takes fewer") {
    const light_shafts::View view{.is_orthographic = false, .position = {0, -4, 0}};
    std::vector<light_shafts::ViewRay> rays;
    for (int y = -8; y <= 8; ++y)
        for (int x = -8; x <= 8; ++x)
            rays.push_back({view.position, glm::normalize(vec3(0.025f * float(x), 1, 0.025f * float(y))), 0.0f, 10.0f});
    double samples_of_large = 0.0;
    for (const float radius_m : {0.4f, 0.004f}) {
        const auto scene = slats_under_a_lamp(radius_m);
        Progress progress;
        light_shafts::Config config{.method = light_shafts::Method::Exact, .light_samples = 4096};
        const light_shafts::Result truth = light_shafts::run(*scene, view, rays, config, progress);
        config.adapts_strata = true;
        for (const float target : {0.1f, 0.03f, 0.01f}) {
            config.error_target = target;
            const light_shafts::Result result = light_shafts::run(*scene, view, rays, config, progress);
            double squared_error = 0.0, sum = 0.0, samples = 0.0;
            for (std::size_t ray = 0; ray < rays.size(); ++ray) {
                squared_error += std::pow(result.radiance[ray].x - truth.radiance[ray].x, 2.0);
                sum += truth.radiance[ray].x;
            }
            for (const auto& count : result.statistics.counts)
                if (count.name == "light shafts: light samples")
                    samples = count.value;
            const auto count = double(rays.size());
            CAPTURE(radius_m);
            CAPTURE(target);
            CAPTURE(samples);
            CHECK(std::sqrt(squared_error / count) / (sum / count) < target);
            CHECK(samples < 4096);
            if (radius_m > 0.1f)
                samples_of_large = samples;
            else
                CHECK(samples <= samples_of_large);
        }
    }
}

TEST_CASE("the number of strata is the least power of two that a deviation needs, within its limit") {
    CHECK(light_shafts::strata_for_error(0.0, 0.01, 64) == 1);
    CHECK(light_shafts::strata_for_error(0.01, 0.01, 64) == 1);
    CHECK(light_shafts::strata_for_error(0.08, 0.01, 64) == 16); // 8^(4/3)
    CHECK(light_shafts::strata_for_error(0.0801, 0.01, 64) == 32);
    CHECK(light_shafts::strata_for_error(1.0, 0.01, 64) == 64);
    CHECK(light_shafts::strata_for_error(1.0, 0.0, 100) == 100);
    CHECK(light_shafts::strata_for_error(0.0, 0.0, 100) == 100); // nothing is known: as many as allowed
}
} // namespace strata_counts_test
