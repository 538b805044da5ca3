// SPDX-License-Identifier: GPL-3.0-or-later
// The texture of the air in whole pictures: what one ray per square of pixels tells the others, and what it must not.
#include "render/frame.hpp"
#include "support/scenes.hpp"
#include <algorithm>
#include <cmath>
#include <doctest/doctest.h>

namespace frame_air_test {
using namespace tyndall;
using namespace tyndall::support;
using render::Film;
using render::FrameConfig;
using render::Pass;

namespace {
Camera camera_above(std::uint32_t size_px = 48) {
    Camera camera;
    camera.world_from_camera = translation({0, 0, 5});
    camera.window_left = camera.window_bottom = -0.45f;
    camera.window_right = camera.window_top = 0.45f;
    camera.width_px = camera.height_px = size_px;
    return camera;
}
/// Fog in [-3, 3]^2 x [0.5, 4.5] over a plate at z = 1, of which the left half is covered by a smaller one at z = 3.
std::unique_ptr<Scene> fog_over_plates(float sun_half_angle_rad = 0.0f) {
    Material fog{.name = "fog"};
    fog.has_surface = false;
    fog.medium_index = 0;
    Light sun{.name = "Sun", .strength = Rgb(3.0f), .towards_light = glm::normalize(vec3(1, 0.3f, 2))};
    sun.half_angle_rad = sun_half_angle_rad;
    return make_scene(
        {{.mesh = cube(), .world_from_object = glm::scale(translation({0, 0, 2.5f}), vec3(3, 3, 2)), .material = fog},
         {.mesh = square(), .world_from_object = glm::scale(translation({0, 0, 1}), vec3(1.5f, 1.5f, 1.0f))},
         {.mesh = square(), .world_from_object = glm::scale(translation({-1, 0, 3}), vec3(0.5f, 1.0f, 1.0f))}},
        {{.name = "fog", .lobes = {{Rgb(0.1f), 0.0f}}}}, {sun});
}
Heterogeneity smooth_air(std::uint32_t upsampling) {
    Heterogeneity air{.upsampling = upsampling};
    air.noise.scale_m = 2.0f;
    air.noise.resolution = 32;
    return air;
}
FrameConfig config_with(const std::optional<Heterogeneity>& air, std::uint32_t samples = 1) {
    FrameConfig config;
    config.pixel_samples = samples;
    for (const Pass pass : {Pass::Depth, Pass::Shafts})
        config.passes.add(pass);
    config.shafts.method = light_shafts::Method::Exact;
    config.heterogeneity = air;
    return config;
}
Film film_of(const Scene& scene, const FrameConfig& config, const Camera& camera = camera_above()) {
    Progress progress;
    return render::render(scene, camera, config, progress);
}
const std::vector<float>& shafts_of(const Film& film) { return film.find(Pass::Shafts)->values; }
double count_of(const Film& film, const std::string& name) {
    for (const auto& count : film.statistics.counts)
        if (count.name == name)
            return count.value;
    return -1.0;
}
} // namespace

TEST_CASE("squares of pixels tell their neighbours what these would have found, and few pixels ask themselves") {
    const auto scene = fog_over_plates();
    const Film full = film_of(*scene, config_with(smooth_air(1))), plain = film_of(*scene, config_with({}));
    const double asked = count_of(full, "heterogeneity: rays");
    double before = asked;
    for (const std::uint32_t side : {2u, 4u, 8u}) {
        CAPTURE(side);
        const Film film = film_of(*scene, config_with(smooth_air(side)));
        double error2 = 0.0, texture2 = 0.0;
        for (std::size_t i = 0; i < shafts_of(full).size(); ++i) {
            error2 += std::pow(double{shafts_of(film)[i]} - double{shafts_of(full)[i]}, 2.0);
            texture2 += std::pow(double{shafts_of(plain)[i]} - double{shafts_of(full)[i]}, 2.0);
        }
        CHECK(std::sqrt(error2 / texture2) < 0.03 * side); // features are 21 pixels wide, and half, and a quarter
        const double now = count_of(film, "heterogeneity: rays");
        CHECK(now < before);
        before = now;
    }
    CHECK(before < 0.25 * asked);
}

TEST_CASE("two sides of a silhouette do not mix: painted air behind an edge does not show in front of it") {
    const auto scene = fog_over_plates();
    // Three times the light below z = 3, where rays that end on the upper plate do not come.
    Heterogeneity air{.amount = 0.0f, .upsampling = 8};
    air.unit_from_scene = glm::inverse(translation({-3, -3, 0}) * glm::scale(mat4(1.0f), vec3(6, 6, 2.999f)));
    air.painted = std::make_shared<const PaintedAir>(PaintedVolume{}, PaintedVolume{},
                                                     PaintedVolume{.size = {1, 1, 1}, .values = {3.0f}});
    const Film plain = film_of(*scene, config_with({})), film = film_of(*scene, config_with(air));
    const std::vector<float>& depth = film.find(Pass::Depth)->values;
    int above = 0, below = 0;
    for (std::size_t pixel = 0; pixel < depth.size(); ++pixel) {
        const double gain = double{shafts_of(film)[3 * pixel]} / double{shafts_of(plain)[3 * pixel]};
        if (depth[pixel] > 0.0f && depth[pixel] < 3.0f) {
            CHECK(std::abs(gain - 1.0) < 1e-5);
            ++above;
        } else {
            CHECK(gain > 1.3);
            ++below;
        }
    }
    CHECK(above > 50);
    CHECK(below > 500);
}

TEST_CASE("bits depend neither on threads nor on the region") {
    for (const float sun_half_angle_rad : {0.0f, 0.1f}) {
        const auto scene = fog_over_plates(sun_half_angle_rad);
        for (const std::uint32_t side : {1u, 4u, 16u}) {
            FrameConfig config = config_with(smooth_air(side), 2);
            config.thread_count = 1;
            const Film one = film_of(*scene, config);
            config.thread_count = 4;
            const Film four = film_of(*scene, config);
            CHECK(shafts_of(one) == shafts_of(four));
            config.region = render::Region{13, 6, 31, 40};
            const Film crop = film_of(*scene, config);
            for (std::uint32_t y = 0; y < crop.height_px; ++y)
                for (std::uint32_t x = 0; x < crop.width_px; ++x)
                    for (std::uint32_t channel = 0; channel < 3; ++channel)
                        REQUIRE(shafts_of(crop)[3 * (y * crop.width_px + x) + channel] ==
                                shafts_of(one)[3 * ((y + 6) * one.width_px + x + 13) + channel]);
        }
    }
}

TEST_CASE("an intensity scales the light shafts of any method to rounding, and nothing else") {
    const auto scene = fog_over_plates(0.05f);
    for (const auto method :
         {light_shafts::Method::Exact, light_shafts::Method::Epipolar, light_shafts::Method::ShadowMap}) {
        FrameConfig config = config_with({}, 4);
        config.shafts.method = method;
        const Film plain = film_of(*scene, config);
        config.heterogeneity = Heterogeneity{.amount = 0.0f, .intensity = 2.0f};
        const Film film = film_of(*scene, config);
        for (std::size_t i = 0; i < shafts_of(film).size(); ++i)
            REQUIRE(std::abs(shafts_of(film)[i] - 2.0f * shafts_of(plain)[i]) <= 1e-6f * shafts_of(film)[i]);
        CHECK(film.find(Pass::Depth)->values == plain.find(Pass::Depth)->values);
    }
}

TEST_CASE("without a medium, or where the air is even, nothing is done, and the statistics say so") {
    const auto empty = make_scene({{.mesh = square()}});
    const auto fog = fog_over_plates();
    for (const auto& [scene, air] :
         {std::pair{empty.get(), smooth_air(1)}, std::pair{fog.get(), Heterogeneity{.amount = 0.0f}}}) {
        const Film film = film_of(*scene, config_with(air));
        CHECK(std::ranges::any_of(film.statistics.skipped,
                                  [](const auto& entry) { return entry.what == "heterogeneity"; }));
        CHECK(count_of(film, "heterogeneity: rays") == -1.0);
        CHECK(film_of(*scene, config_with({})).planes[0].values == film.planes[0].values);
    }
    CHECK_THROWS_AS((void)film_of(*empty, config_with(Heterogeneity{.amount = 2.0f})), InvalidInput);
}
} // namespace frame_air_test
