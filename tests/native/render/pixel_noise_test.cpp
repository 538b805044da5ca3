// SPDX-License-Identifier: GPL-3.0-or-later
// Samples go where a picture is uncertain, and only there.
#include "core/random.hpp"
#include "render/frame.hpp"
#include "render/pixel_noise.hpp"
#include "support/scenes.hpp"
#include <doctest/doctest.h>

namespace pixel_noise_test {
using namespace tyndall;
using namespace tyndall::support;
using render::Pass;

TEST_CASE("the standard error of a mean decides: sigma / sqrt(n) against threshold * sqrt(mean), neighbours included") {
    constexpr std::uint32_t width = 9, height = 7, noisy = 3 * width + 4;
    render::PixelNoise noise(width, height);
    std::vector<std::uint8_t> is_active(width * height, 1);
    // 2 +- 1, alternating: after n samples sigma^2 is n / (n - 1), and the error sqrt(1 / (n - 1)).
    for (std::uint32_t sample = 0; sample < 10; ++sample) {
        for (std::uint32_t pixel = 0; pixel < width * height; ++pixel)
            noise.add(pixel, Rgb(pixel == noisy && sample % 2 == 0 ? 3.0f : pixel == noisy ? 1.0f : 2.0f));
        noise.end_sample(is_active);
    }
    Progress progress;
    const float error = 1.0f / 3.0f / std::sqrt(2.0f); // of the noisy pixel: (1 / 3) / sqrt(mean)
    auto active = is_active;
    CHECK(noise.keep_noisy(1.01f * error, active, progress) == 0);
    active = is_active;
    CHECK(noise.keep_noisy(0.99f * error, active, progress) == 9);
    for (std::uint32_t pixel = 0; pixel < width * height; ++pixel) {
        const bool is_near = pixel / width >= 2 && pixel / width <= 4 && pixel % width >= 3 && pixel % width <= 5;
        CHECK(active[pixel] == (is_near ? 1 : 0));
    }
    // Who has stopped does not start again.
    std::vector<std::uint8_t> stopped(width * height, 0);
    CHECK(noise.keep_noisy(0.99f * error, stopped, progress) == 0);
}

TEST_CASE("lights that take turns are no noise, and what turns differ by is") {
    constexpr std::uint32_t turn_samples = 2, steady = 0, noisy = 4;
    render::PixelNoise noise(7, 1, turn_samples);
    std::vector<std::uint8_t> is_active(7, 1);
    for (std::uint32_t sample = 0; sample < 20; ++sample) { // means of turns: 2, and 2 +- 1
        for (std::uint32_t pixel = 0; pixel < 7; ++pixel)
            if (sample % turn_samples == 0)
                noise.add(pixel, Rgb(pixel != noisy ? 4.0f : sample % 4 == 0 ? 6.0f : 2.0f));
        noise.end_sample(is_active);
    }
    Progress progress;
    const float error = 1.0f / 3.0f / std::sqrt(2.0f); // of ten turns, as of ten samples above
    auto active = is_active;
    CHECK(noise.keep_noisy(1.01f * error, active, progress) == 0);
    active = is_active;
    CHECK(noise.keep_noisy(0.99f * error, active, progress) == 3);
    CHECK(active[steady] == 0);
}

// Seen as black specks in a room that the sky lights through a gap.
TEST_CASE("what has met no light in a few samples is not known to be dark") {
    render::PixelNoise noise(3, 1);
    std::vector<std::uint8_t> is_active(3, 1);
    Progress progress;
    for (std::uint32_t sample = 1; sample <= 16; ++sample) {
        for (std::uint32_t pixel = 0; pixel < 3; ++pixel)
            noise.add(pixel, Rgb(0.0f));
        noise.end_sample(is_active);
        auto active = is_active;
        CHECK(noise.keep_noisy(0.01f, active, progress) == (sample < 16 ? 3 : 0));
    }
}

TEST_CASE("rounds divide the samples, so that none is cut short") {
    for (std::uint32_t samples = 1; samples <= 100; ++samples) {
        const std::uint32_t round = render::samples_per_round(samples);
        CHECK(samples % round == 0);
        CHECK(round >= std::min(samples, 4u));
    }
    CHECK(render::samples_per_round(16) == 4);
    CHECK(render::samples_per_round(10) == 5);
}

TEST_CASE("edges take all samples and keep every bit, the flat rest stops after a round and is as right") {
    Material white{.name = "white"};
    white.constant = {.diffuse_albedo = Rgb(0.0f), .transparent = Rgb(0.0f), .emission = Rgb(0.8f)};
    const auto scene = make_scene({{.mesh = square(), .material = white}}, {}, {});
    Camera camera; // looks down at the square, which fills the middle of the picture
    camera.world_from_camera = translation({0, 0, 5});
    camera.window_left = camera.window_bottom = -0.45f;
    camera.window_right = camera.window_top = 0.45f;
    camera.width_px = camera.height_px = 33;
    render::FrameConfig config;
    config.pixel_samples = 64;
    Progress progress;
    const render::Film all = render::render(*scene, camera, config, progress);
    config.noise_threshold = 0.001f;
    const render::Film some = render::render(*scene, camera, config, progress);
    std::size_t differing = 0, between = 0;
    for (std::size_t pixel = 0; pixel < 33 * 33; ++pixel) {
        const float* a = &all.find(Pass::Combined)->values[4 * pixel];
        const float* b = &some.find(Pass::Combined)->values[4 * pixel];
        if (a[0] > 0.01f && a[0] < 0.79f)
            ++between;
        differing += std::abs(a[0] - b[0]) > 1e-6f ? 1 : 0;
    }
    CHECK(between > 4 * 20); // the square's border
    // A corner of a pixel that none of its first samples nor its neighbours' met is the most that may be missed.
    CHECK(differing == 0);
    double mean_samples = 0.0;
    for (const auto& count : some.statistics.counts)
        if (count.name == "samples per pixel")
            mean_samples = count.value;
    CHECK(mean_samples > 4.0 + 60.0 * double(between) / (33 * 33));
    CHECK(mean_samples < 32.0);
}
} // namespace pixel_noise_test
