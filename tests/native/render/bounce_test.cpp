// SPDX-License-Identifier: GPL-3.0-or-later
// One diffuse bounce against closed forms: furnaces, an integrating sphere, a plate before a disc.
#include "render/indirect_light.hpp"
#include "support/whole_and_part.hpp"
#include <doctest/doctest.h>

namespace bounce_test {
using namespace tyndall;
using namespace tyndall::support;
using render::Film;
using render::FrameConfig;
using render::Pass;

namespace {

FrameConfig bouncing(std::uint32_t pixel_samples, std::uint32_t bounce_samples) {
    FrameConfig config;
    config.pixel_samples = pixel_samples;
    config.indirect.has_bounce = true;
    config.indirect.bounce_samples = bounce_samples;
    return config;
}
/// Many flat faces, all at the same distance from the middle to (pi / rows)^2 / 8.
std::shared_ptr<const TriangleMesh> sphere(std::uint32_t rows) {
    MeshArrays arrays;
    arrays.name = "sphere";
    const std::uint32_t columns = 2 * rows;
    for (std::uint32_t row = 0; row <= rows; ++row)
        for (std::uint32_t column = 0; column < columns; ++column) {
            const float polar = pi * static_cast<float>(row) / static_cast<float>(rows),
                        turn = 2.0f * pi * static_cast<float>(column) / static_cast<float>(columns);
            arrays.positions.emplace_back(std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn),
                                          std::cos(polar));
        }
    for (std::uint32_t row = 0; row < rows; ++row)
        for (std::uint32_t column = 0; column < columns; ++column) {
            const std::uint32_t a = row * columns + column, b = row * columns + (column + 1) % columns;
            arrays.triangles.emplace_back(a, a + columns, b + columns);
            arrays.triangles.emplace_back(a, b + columns, b);
        }
    return mesh_of(std::move(arrays));
}
/// A small grey plate that sees the underside of a disc of radius r at height h, which a sun lights from below.
std::unique_ptr<Scene> plate_below_disc(float radius, float height, const Rgb& colour, std::vector<Part> more = {}) {
    std::vector<Part> parts{
        floor_at(vec3(0.0f), 0.01f, diffuse(Rgb(0.5f))),
        {.mesh = disc(radius), .world_from_object = translation({0, 0, height}), .material = diffuse(colour)}};
    parts[0].casts_shadow = false; // on the disc
    parts.insert(parts.end(), more.begin(), more.end());
    return make_scene(parts, {}, {sun_from({0, 0, -1}, Rgb(3.0f))});
}
Rgb seen(const Scene& scene, const FrameConfig& config, const vec3& place = vec3(0.0f)) {
    return pixel(film_of(scene, camera_on(place, 0.05f), config));
}
} // namespace

TEST_CASE("a closed room that glows by E, with walls of albedo a, shows E (1 + a), as what meshes send straight is no "
          "bounce") {
    const Rgb glow(2.0f, 1.0f, 0.25f), albedo(0.25f, 0.5f, 1.0f);
    const auto room = make_scene({{.mesh = cube(), .material = diffuse(albedo, glow)}});
    FrameConfig off = bouncing(4096, 2);
    off.indirect.has_bounce = false;
    CHECK(relative_error(seen(*room, off, {0.3f, 0.1f, -1}), glow * (1.0f + albedo)) < 5e-3);
}

TEST_CASE("after one bounce it shows E (1 + a + a^2): no light is counted twice") {
    const Rgb glow(2.0f, 1.0f, 0.25f), albedo(0.25f, 0.5f, 1.0f);
    const auto room = make_scene({{.mesh = cube(), .material = diffuse(albedo, glow)}});
    CHECK(relative_error(seen(*room, bouncing(4096, 2), {0.3f, 0.1f, -1}), glow * (1.0f + albedo + albedo * albedo)) <
          1e-2);
}

TEST_CASE("a lamp in the middle of a sphere lights it by a I / (pi r^2), and the bounce adds a times that") {
    Light lamp;
    lamp.name = "Lamp";
    lamp.kind = LightKind::Point;
    lamp.strength = Rgb(7.0f);
    const Rgb albedo(0.9f, 0.5f, 0.1f);
    const auto ball = make_scene({{.mesh = sphere(200), .material = diffuse(albedo)}}, {}, {lamp});
    const Rgb truth = albedo * 7.0f / pi * (1.0f + albedo);
    CHECK(relative_error(seen(*ball, bouncing(4, 4), {0.003f, 0.004f, -1}), truth) < 3e-4);
}

TEST_CASE("a plate before a lit disc takes its colour, by the form factor r^2 / (r^2 + h^2)") {
    const Rgb colour(0.9f, 0.3f, 0.05f);
    for (const float radius : {0.3f, 1.0f, 4.0f}) {
        const float form_factor = radius * radius / (radius * radius + 0.25f);
        const Rgb truth = 0.5f / pi * colour * 3.0f * form_factor;
        CHECK(relative_error(seen(*plate_below_disc(radius, 0.5f, colour), bouncing(512, 8)), truth) <
              3e-3 / std::sqrt(form_factor));
    }
}

TEST_CASE("glass on the way colours what comes through, layer by layer") {
    const Rgb first(0.5f, 0.25f, 1.0f), second(0.5f);
    std::vector<Part> panes{floor_at({0, 0, 0.2f}, 100.0f, pane(first)), floor_at({0, 0, 0.3f}, 100.0f, pane(second))};
    for (Part& glass : panes)
        glass.casts_shadow = false; // from the sun
    const Rgb truth = seen(*plate_below_disc(1.0f, 0.5f, Rgb(0.8f)), bouncing(64, 4)) * first * second;
    CHECK(relative_error(seen(*plate_below_disc(1.0f, 0.5f, Rgb(0.8f), panes), bouncing(64, 4)), truth) < 1e-5);
}

TEST_CASE("fog on the way takes its share, from the plate to the disc and from the sun to both") {
    // The disc is far and large: all rays of interest go up at an angle; a layer of fog between takes exp(-tau / cosine).
    Medium fog{.name = "fog", .lobes = {}, .sigma_a_per_m = Rgb(2.0f)};
    Material inside{.name = "fog"};
    inside.has_surface = false;
    inside.medium_index = 0;
    const Part box{.mesh = cube(),
                   .world_from_object = glm::scale(translation({0, 0, 0.2f}), vec3(1e3f, 1e3f, 0.1f)),
                   .material = inside};
    std::vector<Part> parts{
        floor_at(vec3(0.0f), 0.01f, diffuse(Rgb(0.5f))),
        {.mesh = disc(1e2f), .world_from_object = translation({0, 0, 0.5f}), .material = diffuse(Rgb(0.8f), Rgb(1.0f))},
        box};
    const auto scene = make_scene(parts, {fog});
    // 2 E_3(tau) of a plane that glows by 1, tau = 2 * 0.2; E_3 by its integral.
    double truth = 0.0;
    for (int i = 0; i < 100000; ++i) {
        const double cosine = (i + 0.5) / 1e5;
        truth += 2.0 * cosine * std::exp(-0.4 / cosine) / 1e5;
    }
    CHECK(relative_error(seen(*scene, bouncing(1024, 4)), Rgb(static_cast<float>(0.5 * truth))) < 3e-3);
}

TEST_CASE("with ambient occlusion light is caught within its distance only: what is farther is the world") {
    const auto scene = plate_below_disc(4.0f, 0.5f, Rgb(0.8f));
    FrameConfig config = bouncing(64, 2);
    config.indirect.has_ambient_occlusion = true;
    config.indirect.ambient_distance_m = 0.45f;
    CHECK(seen(*scene, config) == Rgb(0.0f));
    config.indirect.ambient_distance_m = 1e4f;
    const Rgb all = seen(*scene, config);
    config.indirect.ambient_distance_m = 0.0f;
    CHECK(seen(*scene, config) == all);
}

TEST_CASE("several rays are the mean of as many samples with one") {
    const auto scene = plate_below_disc(1.0f, 0.5f, Rgb(0.8f));
    const Rgb one = seen(*scene, bouncing(64, 1)), eight = seen(*scene, bouncing(8, 8));
    CHECK(relative_error(one, eight) < 1e-6);
}

TEST_CASE("a pilot gives an open plain one ray and a room lit by a lamp many") {
    Light lamp;
    lamp.name = "Lamp";
    lamp.kind = LightKind::Point;
    lamp.position = {0.5f, 0.5f, 0.5f};
    lamp.strength = Rgb(5.0f);
    const auto rays_of = [&](const Scene& scene) {
        Camera camera = camera_on({0, 0, -1}, 1.5f);
        camera.window_left = camera.window_bottom = -0.9f;
        camera.window_right = camera.window_top = 0.9f;
        camera.width_px = camera.height_px = 64;
        for (const auto& [name, number] : film_of(scene, camera, bouncing(1, 0)).statistics.counts)
            if (name == "colour bleeding: rays per surface point")
                return number;
        return 0.0;
    };
    CHECK(rays_of(*make_scene({floor_at({0, 0, -1}, 1.0f, diffuse(Rgb(0.8f)))}, {}, {lamp})) == 1.0);
    CHECK(rays_of(*make_scene({{.mesh = cube(), .material = diffuse(Rgb(0.8f))}}, {}, {lamp})) > 2.0);
}

TEST_CASE("where nothing shines nothing is gathered, and the statistics say so") {
    const auto scene = make_scene({{.mesh = cube(), .material = diffuse(Rgb(0.8f))}});
    const Film film = film_of(*scene, camera_on({0, 0, -1}, 0.5f), bouncing(1, 0));
    bool is_said = false;
    for (const auto& [what, reason] : film.statistics.skipped)
        is_said = is_said || (what == "colour bleeding" && reason == "nothing shines");
    CHECK(is_said);
}

TEST_CASE("bits of indirect light depend neither on the number of threads nor on the region") {
    Light lamp;
    lamp.name = "Lamp";
    lamp.kind = LightKind::Point;
    lamp.position = {0.2f, 0.3f, 0.8f};
    lamp.radius_m = 0.1f;
    const auto scene = in_world({{.mesh = cube(), .material = diffuse(Rgb(0.2f, 0.5f, 0.8f))},
                                 floor_at({0.4f, 0.0f, 0.0f}, 0.3f, pane(Rgb(0.5f)))},
                                Rgb(1.0f), {lamp});
    Camera camera = camera_on({0, 0, -1}, 1.5f);
    camera.window_left = camera.window_bottom = -0.9f;
    camera.window_right = camera.window_top = 0.9f;
    camera.width_px = camera.height_px = 40;
    FrameConfig config = bouncing(3, 0);
    config.passes.add(Pass::AmbientOcclusion);
    check_whole_and_part(*scene, camera, config);
}
} // namespace bounce_test
