// SPDX-License-Identifier: GPL-3.0-or-later
// Whole pictures whose value at every pixel is known in closed form.
#include "render/frame.hpp"
#include "support/fog_draws.hpp"
#include "support/one_point.hpp"
#include "support/scenes.hpp"
#include <cmath>
#include <doctest/doctest.h>
#include <thread>

namespace frame_test {
using namespace tyndall;
using namespace tyndall::support;
using render::Film;
using render::FrameConfig;
using render::Pass;

namespace {

/// Looks straight down from z = 5 at the square [-1, 1]^2 and a little beside it.
Camera camera_above(std::uint32_t size_px) {
    Camera camera;
    camera.world_from_camera = translation({0, 0, 5});
    camera.window_left = camera.window_bottom = -0.45f;
    camera.window_right = camera.window_top = 0.45f;
    camera.width_px = camera.height_px = size_px;
    return camera;
}
Material diffuse(const Rgb& albedo) {
    Material material{.name = "diffuse"};
    material.constant = {.diffuse_albedo = albedo, .transparent = Rgb(0.0f), .emission = Rgb(0.0f)};
    return material;
}
Material see_through(const Rgb& transparent, const Rgb& emission = Rgb(0.0f)) {
    Material material{.name = "see-through"};
    material.constant = {.diffuse_albedo = Rgb(0.0f), .transparent = transparent, .emission = emission};
    return material;
}
Light sun(const Rgb& irradiance, const vec3& towards) {
    Light light;
    light.name = "Sun";
    light.strength = irradiance;
    light.towards_light = glm::normalize(towards);
    return light;
}
FrameConfig config_with(std::uint32_t samples, std::initializer_list<Pass> passes = {}) {
    FrameConfig config;
    config.pixel_samples = samples;
    for (const Pass pass : passes)
        config.passes.add(pass);
    return config;
}
Film film_of(const Scene& scene, const Camera& camera, const FrameConfig& config) {
    Progress progress;
    return render::render(scene, camera, config, progress);
}
/// Colour of a pixel, x right and y up from the lower left corner.
Rgb colour(const Film& film, Pass pass, std::uint32_t x, std::uint32_t y) {
    const std::uint32_t channel_count = render::layout(pass).channel_count;
    const float* value = &film.find(pass)->values[(std::size_t{y} * film.width_px + x) * channel_count];
    return channel_count == 1 ? Rgb(value[0]) : Rgb(value[0], value[1], value[2]);
}
double relative_error(const Rgb& value, const Rgb& truth) {
    return glm::length(glm::dvec3(value) - glm::dvec3(truth)) / glm::length(glm::dvec3(truth));
}
} // namespace

TEST_CASE("a white surface in a uniformly bright world is invisible: the white furnace") {
    const auto scene = in_world({{.mesh = square(), .material = diffuse(Rgb(1.0f))}}, Rgb(1.0f));
    const Film film = film_of(*scene, camera_above(8), config_with(4));
    for (std::uint32_t y = 0; y < 8; ++y)
        for (std::uint32_t x = 0; x < 8; ++x)
            CHECK(relative_error(colour(film, Pass::Combined, x, y), Rgb(1.0f)) < 1e-6);
}

// Seen to fail by up to 62 % where 256 directions stand for the world, whatever the fog.
TEST_CASE("fog in a uniformly bright world is invisible where nothing dims light on its way, scattered forward, too") {
    for (const float asymmetry_g : {0.0f, 0.9f, -0.9f, 0.99f}) {
        CAPTURE(asymmetry_g);
        const auto scene = in_world({box_of(0, vec3(0.0f), vec3(1.0f))}, Rgb(1.0f), {},
                                    {{.name = "fog", .lobes = {{Rgb(0.9f, 0.6f, 0.3f), asymmetry_g}}}});
        FrameConfig config = config_with(16);
        config.shafts.world_samples = 256;
        config.shafts.attenuates_light = false;
        const Film film = film_of(*scene, camera_above(8), config);
        for (std::uint32_t y = 0; y < 8; ++y)
            for (std::uint32_t x = 0; x < 8; ++x)
                CHECK(relative_error(colour(film, Pass::Combined, x, y), Rgb(1.0f)) < 6e-3);
    }
}

TEST_CASE("a sun lights a plane by its irradiance times the cosine, from either side") {
    const Rgb irradiance(3.0f, 2.0f, 1.0f), albedo(0.8f, 0.5f, 0.2f);
    for (const vec3 towards : {vec3(0, 0, 1), vec3(1, 0, 1), vec3(0.3f, -2, 0.5f)})
        for (const float turned : {0.0f, pi}) {
            const Part part{.mesh = square(),
                            .world_from_object = glm::rotate(mat4(1.0f), turned, vec3(1, 0, 0)),
                            .material = diffuse(albedo)};
            const auto scene = make_scene({part}, {}, {sun(irradiance, towards)});
            const Rgb truth = irradiance * albedo / pi * glm::normalize(towards).z;
            CHECK(relative_error(colour(film_of(*scene, camera_above(3), config_with(1)), Pass::Combined, 1, 1),
                                 truth) < 1e-6);
        }
}

TEST_CASE("a point light falls off with the square of its distance and the cosine") {
    Light lamp;
    lamp.name = "Lamp";
    lamp.kind = LightKind::Point;
    lamp.strength = Rgb(7.0f);
    for (const vec3 place : {vec3(0, 0, 1), vec3(0, 0, 3), vec3(2, 1, 0.5f)}) {
        lamp.position = place;
        const auto scene = make_scene({{.mesh = square(), .material = diffuse(Rgb(1.0f))}}, {}, {lamp});
        const float distance = glm::length(place);
        const Rgb truth(7.0f / pi * place.z / (distance * distance * distance));
        CHECK(relative_error(colour(film_of(*scene, camera_above(3), config_with(1)), Pass::Combined, 1, 1), truth) <
              1e-6);
    }
}

TEST_CASE("an occluder casts a shadow, and the Shadow pass tells how much passes") {
    const Part floor{.mesh = square(), .material = diffuse(Rgb(0.5f))};
    Part pane{.mesh = square(),
              .world_from_object = translation({0, 0, 10}), // behind the camera, before the sun
              .material = see_through(Rgb(0.25f, 0.5f, 0.0f))};
    const std::vector<Light> lights{sun(Rgb(2.0f), {0.03f, 0.01f, 1})};
    const FrameConfig config = config_with(1, {Pass::Shadow});
    const Film film = film_of(*make_scene({floor, pane}, {}, lights), camera_above(3), config);
    const float cosine = glm::normalize(vec3(0.03f, 0.01f, 1)).z; // off the pane's diagonal, which two triangles share
    CHECK(relative_error(colour(film, Pass::Combined, 1, 1), Rgb(0.25f, 0.5f, 0.0f) * cosine / pi) < 1e-6);
    CHECK(relative_error(colour(film, Pass::Shadow, 1, 1), Rgb(0.25f, 0.5f, 0.0f)) < 1e-6);
    pane.casts_shadow = false;
    const Film unshadowed = film_of(*make_scene({floor, pane}, {}, lights), camera_above(3), config);
    CHECK(colour(unshadowed, Pass::Shadow, 1, 1) == Rgb(1.0f));
}

TEST_CASE("a stack of panes lets the product of their shares pass, and each adds its own light") {
    const std::vector<Rgb> shares{{0.5f, 0.9f, 1.0f}, {0.25f, 0.5f, 0.75f}, {0.8f, 0.1f, 0.6f}};
    const Rgb glow(0.125f), world(4.0f, 2.0f, 1.0f);
    std::vector<Part> panes;
    Rgb truth(0.0f), passing(1.0f);
    for (const Rgb& share : shares) {
        panes.push_back({.mesh = square(),
                         .world_from_object = translation({0, 0, -static_cast<float>(panes.size())}),
                         .material = see_through(share, glow)});
        truth += passing * glow;
        passing *= share;
    }
    truth += passing * world;
    const auto scene = in_world(panes, world);
    const Film film = film_of(*scene, camera_above(3), config_with(1, {Pass::Emission}));
    CHECK(relative_error(colour(film, Pass::Combined, 1, 1), truth) < 1e-6);
    CHECK(relative_error(colour(film, Pass::Emission, 1, 1), truth - passing * world) < 1e-6);

    SUBCASE("a transparent film counts as alpha what covers the world, and leaves the world out") {
        FrameConfig config = config_with(1);
        config.is_film_transparent = true;
        const Film clear = film_of(*scene, camera_above(3), config);
        CHECK(relative_error(colour(clear, Pass::Combined, 1, 1), truth - passing * world) < 1e-6);
        const float alpha = clear.planes[0].values[4 * 4 + 3];
        CHECK(std::abs(alpha - (1.0f - (passing.x + passing.y + passing.z) / 3.0f)) < 1e-6f);
        CHECK(clear.planes[0].values[3] == 0.0f); // beside the panes
    }
}

TEST_CASE("a fog box dims what lies behind it by exp(-sigma_t d), and its surface is never seen") {
    Material fog{.name = "fog"};
    fog.has_surface = false;
    fog.medium_index = 0;
    Medium medium{.name = "fog", .lobes = {}, .sigma_a_per_m = {0.1f, 0.2f, 0.4f}, .emission_w_per_m3_sr = Rgb(0.0f)};
    const Part box{.mesh = cube(), .world_from_object = translation({0, 0, 2}), .material = fog}; // 2 m thick
    const Part glowing{.mesh = square(), .material = see_through(Rgb(0.0f), Rgb(1.0f))};
    const auto scene = make_scene({glowing, box}, {medium});
    const Film film = film_of(*scene, camera_above(3), config_with(1, {Pass::Transmittance, Pass::Depth}));
    const Rgb truth(std::exp(-0.2f), std::exp(-0.4f), std::exp(-0.8f));
    CHECK(relative_error(colour(film, Pass::Combined, 1, 1), truth) < 1e-6);
    CHECK(relative_error(colour(film, Pass::Transmittance, 1, 1), truth) < 1e-6);
    CHECK(relative_error(colour(film, Pass::Depth, 1, 1), Rgb(5.0f)) < 1e-6);
}

TEST_CASE("light on its way to a surface is dimmed by the fog, too") {
    Material fog{.name = "fog"};
    fog.has_surface = false;
    fog.medium_index = 0;
    Medium medium{.name = "fog", .lobes = {}, .sigma_a_per_m = Rgb(0.3f), .emission_w_per_m3_sr = Rgb(0.0f)};
    const Part box{.mesh = cube(), .world_from_object = translation({3, 0, 2}), .material = fog}; // beside the view
    const Part floor{.mesh = square(), .material = diffuse(Rgb(1.0f))};
    const auto scene = make_scene({floor, box}, {medium}, {sun(Rgb(1.0f), {3, 0, 2})}); // through the box's middle
    const vec3 towards = glm::normalize(vec3(3, 0, 2));
    const float inside_m = 2.0f / towards.x; // enters at x = 2, leaves at x = 4
    const Rgb truth(towards.z / pi * std::exp(-0.3f * inside_m));
    CHECK(relative_error(colour(film_of(*scene, camera_above(3), config_with(1)), Pass::Combined, 1, 1), truth) < 1e-6);
}

TEST_CASE("a sun in an endless medium is black, and the report names the remedy") {
    SceneDescription description = description_of(
        *make_scene({{.mesh = square()}},
                    {{.name = "haze", .lobes = {}, .sigma_a_per_m = Rgb(1e-3f), .emission_w_per_m3_sr = Rgb(0.0f)}},
                    {sun(Rgb(1.0f), {0, 0, 1})}));
    description.world_medium_index = 0;
    const Scene scene(std::move(description), Progress());
    const Film film = film_of(scene, camera_above(3), config_with(1));
    CHECK(colour(film, Pass::Combined, 1, 1) == Rgb(0.0f));
    REQUIRE(film.statistics.reports.size() == 1);
    CHECK(film.statistics.reports[0].find("\"Sun\"") != std::string::npos);
    CHECK(film.statistics.reports[0].find("fog box") != std::string::npos);
}

TEST_CASE("the geometric passes say where the first surface is, in the world's space") {
    SceneDescription description =
        description_of(*make_scene({{.mesh = square(), .material = diffuse({0.1f, 0.2f, 0.3f})}}));
    description.origin_in_world = {60'000.0, 0.0, 10.0};
    const Scene scene(std::move(description), Progress());
    const Film film = film_of(scene, camera_above(3),
                              config_with(1, {Pass::Depth, Pass::Normal, Pass::Position, Pass::DiffuseColour}));
    CHECK(relative_error(colour(film, Pass::Depth, 1, 1), Rgb(5.0f)) < 1e-6);
    CHECK(colour(film, Pass::Normal, 1, 1) == Rgb(0, 0, 1));
    CHECK(relative_error(colour(film, Pass::Position, 1, 1), Rgb(60'000.0f, 0.0f, 10.0f)) < 1e-6);
    CHECK(relative_error(colour(film, Pass::DiffuseColour, 1, 1), Rgb(0.1f, 0.2f, 0.3f)) < 1e-6);
    CHECK(colour(film, Pass::Depth, 0, 0) == Rgb(1e10f)); // beside the square
    CHECK(colour(film, Pass::Normal, 0, 0) == Rgb(0.0f));
}

TEST_CASE("a window shows what is behind it in the geometric passes: less than half of it is there") {
    const Part pane{.mesh = square(), .world_from_object = translation({0, 0, 2}), .material = see_through(Rgb(0.6f))};
    const auto scene = make_scene({pane, {.mesh = square()}});
    const Film film = film_of(*scene, camera_above(3), config_with(1, {Pass::Depth}));
    CHECK(relative_error(colour(film, Pass::Depth, 1, 1), Rgb(5.0f)) < 1e-6);
}

TEST_CASE("a filter leaves a uniform picture uniform, whatever its width") {
    const auto scene = in_world({}, Rgb(0.7f));
    for (const render::PixelFilter filter :
         {render::PixelFilter::Box, render::PixelFilter::Gaussian, render::PixelFilter::BlackmanHarris}) {
        FrameConfig config = config_with(5);
        config.pixel_filter = filter;
        config.filter_width_px = 3.0f;
        const Film film = film_of(*scene, camera_above(4), config);
        for (std::uint32_t x = 0; x < 4; ++x)
            CHECK(relative_error(colour(film, Pass::Combined, x, x), Rgb(0.7f)) < 1e-6);
    }
}

/// A scene that uses random numbers for the filter, a light with a size and the world.
static std::unique_ptr<Scene> noisy_scene() {
    Light lamp;
    lamp.name = "Lamp";
    lamp.kind = LightKind::Point;
    lamp.strength = Rgb(5.0f);
    lamp.position = {1, 1, 2};
    lamp.radius_m = 0.5f;
    return in_world(
        {{.mesh = square(), .material = diffuse(Rgb(0.8f))},
         {.mesh = cube(), .world_from_object = glm::scale(translation({0.2f, 0, 0.4f}), vec3(0.3f))},
         {.mesh = square(), .world_from_object = translation({0.5f, 0, 1}), .material = see_through(Rgb(0.5f))}},
        Rgb(0.3f), {lamp});
}

TEST_CASE("a region is a crop of the full frame, bit for bit, but for what pixels share at its border") {
    const auto scene = noisy_scene();
    const Camera camera = camera_above(24);
    for (const bool shares : {false, true}) {
        FrameConfig config = config_with(3);
        config.shafts.shares_strata = shares;
        const Film full = film_of(*scene, camera, config);
        config.region = render::Region{5, 7, 18, 21};
        const Film crop = film_of(*scene, camera, config);
        REQUIRE(crop.width_px == 13);
        REQUIRE(crop.height_px == 14);
        const std::uint32_t border = shares ? 2 : 0;
        for (std::uint32_t y = border; y < crop.height_px - border; ++y)
            for (std::uint32_t x = border; x < crop.width_px - border; ++x)
                REQUIRE(colour(crop, Pass::Combined, x, y) == colour(full, Pass::Combined, x + 5, y + 7));
    }
}

// Seen to fail under the threshold, at the tiles' borders, without the margin.
TEST_CASE("tiles put together are the full frame, bit for bit, also where pixels share light or stop early") {
    const auto scene = noisy_scene();
    constexpr std::uint32_t size = 72;
    const Camera camera = camera_above(size);
    for (const float noise_threshold : {0.0f, 0.05f}) {
        CAPTURE(noise_threshold);
        FrameConfig config = config_with(noise_threshold > 0.0f ? 12 : 3, {Pass::Normal, Pass::Depth, Pass::Shadow});
        config.shafts.shares_strata = true;
        config.noise_threshold = noise_threshold;
        const Film full = film_of(*scene, camera, config);
        config.is_tile = true;
        for (const render::Region tile :
             {render::Region{0, 0, 31, size}, {31, 0, size, 39}, {31, 39, size, size}, {60, 5, 61, 6}}) {
            config.region = tile;
            const Film part = film_of(*scene, camera, config);
            REQUIRE(part.width_px == tile.x1 - tile.x0);
            REQUIRE(part.planes.size() == full.planes.size());
            std::size_t different = 0;
            for (const render::Plane& plane : part.planes) {
                const std::size_t channels = layout(plane.pass).channel_count;
                std::size_t next = 0;
                for (std::uint32_t y = tile.y0; y < tile.y1; ++y)
                    for (std::size_t at = (std::size_t{y} * size + tile.x0) * channels;
                         at < (std::size_t{y} * size + tile.x1) * channels; ++at)
                        different += plane.values[next++] != full.find(plane.pass)->values[at] ? 1 : 0;
            }
            CHECK(different == 0);
        }
    }
}

TEST_CASE("the picture's bits do not depend on the number of threads") {
    const auto scene = noisy_scene();
    FrameConfig config = config_with(4, {Pass::Normal, Pass::Shadow});
    config.thread_count = 1;
    const Film one = film_of(*scene, camera_above(40), config);
    config.thread_count = 4;
    const Film four = film_of(*scene, camera_above(40), config);
    for (std::size_t plane = 0; plane < one.planes.size(); ++plane)
        CHECK(one.planes[plane].values == four.planes[plane].values);
}

TEST_CASE("another seed gives other noise around the same picture") {
    const auto scene = noisy_scene();
    FrameConfig config = config_with(1);
    const Film first = film_of(*scene, camera_above(16), config);
    config.seed = 1;
    CHECK(film_of(*scene, camera_above(16), config).planes[0].values != first.planes[0].values);
}

TEST_CASE("the picture so far is handed out while it grows, and the last update is not the end") {
    const auto scene = noisy_scene();
    Progress progress;
    std::size_t update_count = 0;
    const Film film = render::render(*scene, camera_above(16), config_with(8), progress, [&](const Film& so_far) {
        CHECK(so_far.planes[0].values.size() == 16u * 16u * 4u);
        ++update_count;
    });
    CHECK(update_count >= 1);
    CHECK(progress.fraction() == 1.0f);
}

TEST_CASE("cancel ends a long frame") {
    const auto scene = noisy_scene();
    Progress progress;
    std::thread impatient([&] {
        while (progress.fraction() == 0.0f)
            std::this_thread::yield();
        progress.cancel();
    });
    CHECK_THROWS_AS((void)render::render(*scene, camera_above(64), config_with(65536), progress), Cancelled);
    impatient.join();
}

TEST_CASE("without a medium nothing is done for shafts, and the statistics say so") {
    const Film film = film_of(*noisy_scene(), camera_above(4), config_with(1));
    REQUIRE(film.statistics.skipped.size() == 1);
    CHECK(film.statistics.skipped[0].what == "light shafts");
    CHECK(film.statistics.skipped[0].reason == "no medium in the scene");
}

TEST_CASE("a frame that cannot be rendered is refused by name") {
    const auto scene = noisy_scene();
    FrameConfig config = config_with(0);
    CHECK_THROWS_AS((void)film_of(*scene, camera_above(4), config), InvalidInput);
    config = config_with(1);
    config.region = render::Region{0, 0, 5, 4};
    CHECK_THROWS_AS((void)film_of(*scene, camera_above(4), config), InvalidInput);
    CHECK_THROWS_AS((void)film_of(*scene, camera_above(0), config_with(1)), InvalidInput);
    CHECK_THROWS_AS((void)render::pass_named("Beauty"), InvalidInput);
}
} // namespace frame_test
