// SPDX-License-Identifier: GPL-3.0-or-later
// Neighbours share the world's light where they lie in one plane, and nowhere else.
#include "render/frame.hpp"
#include "render/shared_irradiance.hpp"
#include "support/close_to.hpp"
#include "support/scenes.hpp"
#include <array>
#include <cmath>
#include <doctest/doctest.h>

namespace shared_irradiance_test {
using namespace tyndall;
using namespace tyndall::support;
using render::Pass;
using render::WorldLit;

namespace {
constexpr std::uint32_t width = 11, height = 9;
/// Points of the ground, a metre apart.
std::vector<WorldLit> ground() {
    std::vector<WorldLit> pixels;
    for (std::uint32_t pixel = 0; pixel < width * height; ++pixel)
        pixels.push_back({.position = vec3(float(pixel % width), float(pixel / width), 0.0f),
                          .normal = vec3(0, 0, 1),
                          .albedo = Rgb(0.5f, 0.25f, 1.0f),
                          .irradiance = Rgb(2.0f)});
    return pixels;
}
} // namespace

TEST_CASE("a ray that finds light lights its neighbours by a tent: all that it brought, spread, and no more") {
    for (const std::uint32_t reach : {1u, 2u}) {
        std::vector<WorldLit> pixels = ground();
        for (WorldLit& pixel : pixels)
            pixel.irradiance = Rgb(0.0f);
        pixels[4 * width + 5].irradiance = Rgb(8.0f);
        Rgb gain(0.0f);
        for (std::uint32_t y = 0; y < height; ++y)
            for (std::uint32_t x = 0; x < width; ++x) {
                const Rgb here = render::shared_light_gain(pixels, width, reach, x, y);
                const bool is_near = std::max(std::abs(int(x) - 5), std::abs(int(y) - 4)) <= int(reach);
                CHECK((here != Rgb(0.0f)) == is_near);
                gain += here;
            }
        CHECK(glm::length(gain) < 1e-5f);
        CHECK(render::shared_light_gain(pixels, width, reach, 5, 4).x ==
              close_to(0.5f * (8.0f / float(4 * reach * reach) - 8.0f), 1e-5));
    }
}

TEST_CASE("even light stays as it is, textures stay sharp, and what lies elsewhere is not asked") {
    std::vector<WorldLit> pixels = ground();
    pixels[4 * width + 5].albedo = Rgb(0.9f);
    const auto at = [&](std::uint32_t x, std::uint32_t y) -> WorldLit& { return pixels[y * width + x]; };
    at(3, 3).albedo = Rgb(0.0f), at(3, 3).irradiance = Rgb(100.0f);     // sky
    at(4, 5).position.z = 3.0f, at(4, 5).irradiance = Rgb(100.0f);      // a table above the ground
    at(6, 3).normal = vec3(0, 1, 0), at(6, 3).irradiance = Rgb(100.0f); // a wall
    for (std::uint32_t y = 0; y < height; ++y)
        for (std::uint32_t x = 0; x < width; ++x)
            CHECK(render::shared_light_gain(pixels, width, 2, x, y) == Rgb(0.0f));
}

TEST_CASE("sharing ends with enough rays of one's own") {
    CHECK(render::shared_reach_px(2) == 2);
    CHECK(render::shared_reach_px(17) == 1);
    CHECK(render::shared_reach_px(65) == 0);
}

TEST_CASE("below a slit to the sky, a picture of one sample has the light of the converged one, with less noise") {
    std::vector<Part> parts{{.mesh = square(), .world_from_object = glm::scale(translation({0, 0, 0}), vec3(3.0f))}};
    parts.front().material.constant = {.diffuse_albedo = Rgb(0.5f), .transparent = Rgb(0.0f), .emission = Rgb(0.0f)};
    for (const float side : {-1.0f, 1.0f})
        parts.push_back(
            {.mesh = square(), .world_from_object = glm::scale(translation({side * 3.4f, 0, 1}), vec3(3.0f))});
    SceneDescription description = description_of(*make_scene(parts));
    description.world = World("sky", Rgb(1.0f));
    const Scene scene(std::move(description), Progress());
    Camera camera;
    camera.world_from_camera = translation({0, 0, 0.9f});
    camera.clip_near_m = 0.01f;
    camera.width_px = camera.height_px = 64;
    render::FrameConfig config;
    Progress progress;
    const auto render_with = [&](std::uint32_t samples, bool shares, std::uint32_t seed) {
        config.pixel_samples = samples, config.shafts.shares_strata = shares, config.seed = seed;
        return render::render(scene, camera, config, progress).planes.front().values;
    };
    const std::vector<float> truth = render_with(256, false, 1);
    std::array<double, 2> squared_error{}, mean{};
    double true_mean = 0.0;
    for (const int shares : {0, 1}) {
        const std::vector<float> picture = render_with(1, shares == 1, 2);
        for (std::size_t pixel = 0; pixel < 64 * 64; ++pixel) {
            squared_error[std::size_t(shares)] += std::pow(double(picture[4 * pixel]) - truth[4 * pixel], 2.0);
            mean[std::size_t(shares)] += picture[4 * pixel];
            true_mean += 0.5 * truth[4 * pixel];
        }
    }
    CHECK(squared_error[1] < 0.5 * squared_error[0]); // with fewer rays, too
    // The mean's standard error, and four of them; an error that 21 pixels share counts as often.
    CHECK(std::abs(mean[0] - true_mean) < 4.0 * std::sqrt(squared_error[0]));
    CHECK(std::abs(mean[1] - true_mean) < 4.0 * std::sqrt(21.0 * squared_error[1]));
}
} // namespace shared_irradiance_test
