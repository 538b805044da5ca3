// SPDX-License-Identifier: GPL-3.0-or-later
// What mirrors show: the mirrored scene, Fresnel's share of the world, and each other so often as they may.
#include "shading/fresnel.hpp"
#include "support/close_to.hpp"
#include "support/whole_and_part.hpp"
#include <doctest/doctest.h>

namespace mirror_test {
using namespace tyndall;
using namespace tyndall::support;
using render::Film;
using render::FrameConfig;
using render::Pass;

namespace {
Material mirror(const Rgb& facing, const Rgb& edge, const Rgb& emission = Rgb(0.0f)) {
    Material material = diffuse(Rgb(0.0f), emission);
    material.name = "mirror";
    material.gloss = GlossLayers{.constant = {.facing = facing, .edge = edge}};
    return material;
}
Material coated(const Rgb& albedo, float ior) {
    Material material = diffuse(Rgb(0.0f));
    material.gloss = GlossLayers{.constant = {.coat = Rgb(1.0f), .coated = albedo}, .coat_ior = ior};
    return material;
}
FrameConfig mirroring(std::uint32_t depth) {
    FrameConfig config;
    config.pixel_samples = 1;
    config.indirect.mirror_depth = depth;
    return config;
}
/// At an angle to a floor's normal, on one of its points.
Camera camera_askew(float angle_rad) {
    Camera camera = camera_on(vec3(0.0f), 0.0f);
    camera.world_from_camera = glm::rotate(mat4(1.0f), angle_rad, vec3(1, 0, 0)) * translation({0, 0, 0.5f});
    return camera;
}
} // namespace

TEST_CASE("a plane mirror shows what stands before it as if that stood mirrored behind it") {
    Light lamp;
    lamp.name = "Lamp";
    lamp.kind = LightKind::Point;
    lamp.strength = Rgb(9.0f, 5.0f, 3.0f);
    lamp.position = {0.5f, -0.4f, 4.0f};
    std::vector<Part> things{{.mesh = cube(),
                              .world_from_object = glm::scale(
                                  glm::rotate(translation({-0.4f, 0.3f, 0.9f}), 0.7f, vec3(1, 2, 3)), vec3(0.4f)),
                              .material = diffuse(Rgb(0.8f, 0.3f, 0.1f))},
                             {.mesh = square(),
                              .world_from_object = glm::rotate(translation({0.6f, 0.0f, 0.8f}), 0.6f, vec3(0, 1, 0.2f)),
                              .material = diffuse(Rgb(0.1f, 0.5f, 0.9f), Rgb(0.05f))}};
    for (Part& thing : things)
        thing.is_camera_visible = false; // but for the mirror
    const Rgb silver(0.9f, 0.8f, 0.7f), sky(0.02f, 0.03f, 0.04f);
    Part glass = floor_at(vec3(0.0f), 50.0f, mirror(silver, silver));
    glass.casts_shadow = false;
    std::vector<Part> before = things;
    before.push_back(glass);
    std::vector<Part> behind = things;
    const mat4 mirrored = glm::scale(mat4(1.0f), vec3(1, 1, -1));
    for (Part& thing : behind) {
        thing.is_camera_visible = true;
        thing.world_from_object = mirrored * thing.world_from_object;
    }
    // The world lights by chance: it is asked for in neither.
    Camera camera;
    camera.world_from_camera = translation({0, 0, 5});
    camera.window_left = camera.window_bottom = -0.3f;
    camera.window_right = camera.window_top = 0.3f;
    camera.width_px = camera.height_px = 48;
    const auto without_its_glow_on_others = [&](const std::vector<Part>& parts) {
        SceneDescription description = description_of(*make_scene(parts, {}, {lamp})); // its samples would differ
        for (Instance& instance : description.instances)
            instance.is_bounce_visible = false;
        return std::make_unique<Scene>(std::move(description), Progress());
    };
    const Film shown = film_of(*without_its_glow_on_others(before), camera, mirroring(1));
    lamp.position.z = -4.0f;
    const Film truth = film_of(*without_its_glow_on_others(behind), camera, mirroring(1));
    int dark = 0, other = 0;
    for (std::size_t pixel = 0; pixel < 48 * 48; ++pixel) {
        const float* seen = &shown.planes[0].values[4 * pixel];
        const float* direct = &truth.planes[0].values[4 * pixel];
        const Rgb expected = silver * Rgb(direct[0], direct[1], direct[2]);
        dark += expected == Rgb(0.0f);
        other += glm::length(Rgb(seen[0], seen[1], seen[2]) - expected) > 1e-4f * (0.01f + glm::length(expected));
        CHECK(seen[3] == 1.0f);
    }
    CHECK(dark > 200);
    CHECK(dark < 1800);
    CHECK(other < 6); // on edges, and where a thing shadows itself
}

TEST_CASE("a coat mirrors Fresnel's share of the world, and lets the rest in: over white nothing is lost") {
    for (const float angle_rad : {0.0f, 0.5f, 1.0f, 1.4f}) {
        CAPTURE(angle_rad);
        const float share = fresnel_dielectric(std::cos(angle_rad), 1.5f);
        const auto black = in_world({floor_at(vec3(0.0f), 1.0f, coated(Rgb(0.0f), 1.5f))}, Rgb(2.0f));
        CHECK(relative_error(pixel(film_of(*black, camera_askew(angle_rad), mirroring(1))), Rgb(2.0f * share)) < 2e-5);
        const auto white = in_world({floor_at(vec3(0.0f), 1.0f, coated(Rgb(1.0f), 1.5f))}, Rgb(2.0f));
        CHECK(relative_error(pixel(film_of(*white, camera_askew(angle_rad), mirroring(1))), Rgb(2.0f)) < 2e-5);
        const Rgb gold(1.0f, 0.7f, 0.3f);
        const float rise = std::pow(1.0f - std::cos(angle_rad), 5.0f);
        const auto metal = in_world({floor_at(vec3(0.0f), 1.0f, mirror(gold, Rgb(1.0f)))}, Rgb(2.0f));
        CHECK(relative_error(pixel(film_of(*metal, camera_askew(angle_rad), mirroring(1))),
                             2.0f * (gold + (1.0f - gold) * rise)) < 2e-5);
    }
}

TEST_CASE("a mirror shows the world's light, not what cameras see in its place") {
    const auto black = std::make_shared<const EnvironmentImage>(
        EnvironmentImage{.name = "black", .width = 2, .height = 1, .pixels = std::vector<vec4>(2, vec4(0.0f))});
    SceneDescription description =
        description_of(*make_scene({floor_at(vec3(0.0f), 1.0f, mirror(Rgb(0.5f), Rgb(0.5f)))}));
    description.world = World("World", Rgb(2.0f), nullptr, mat3(1.0f), SeenWorld{.image = black});
    const Scene scene(std::move(description), Progress());
    CHECK(relative_error(pixel(film_of(scene, camera_on(vec3(0.0f), 0.5f), mirroring(1))), Rgb(1.0f)) < 1e-6);
    CHECK(pixel(film_of(scene, camera_on(vec3(5.0f, 0.0f, 0.0f), 0.5f), mirroring(1))) == Rgb(0.0f));
}

TEST_CASE("in a room of mirrors that glow by E each mirror adds its share, and the first beyond the depth") {
    const Rgb share(0.5f, 0.9f, 1.0f), glow(1.0f, 2.0f, 3.0f);
    const auto room = make_scene({{.mesh = cube(), .material = mirror(share, share, glow)}});
    Rgb truth = glow, term = glow;
    for (const std::uint32_t depth : {0u, 1u, 2u, 3u, 7u}) {
        truth = term = glow;
        for (std::uint32_t mirrors = 0; depth > 0 && mirrors < depth + 1; ++mirrors)
            truth += term *= share;
        CHECK(relative_error(pixel(film_of(*room, camera_on({0.2f, 0.1f, -1}, 0.7f), mirroring(depth))), truth) < 1e-6);
    }
}

TEST_CASE("through a film without a sky mirrors show it, and panes that mirror let the rest pass") {
    Material half = pane(Rgb(0.5f));
    half.gloss = GlossLayers{.constant = {.facing = Rgb(0.25f), .edge = Rgb(0.25f)}};
    const auto scene = in_world({floor_at(vec3(0.0f), 1.0f, half)}, Rgb(2.0f));
    FrameConfig config = mirroring(1);
    const Film opaque = film_of(*scene, camera_on(vec3(0.0f), 0.1f), config);
    CHECK(relative_error(pixel(opaque), Rgb(0.25f * 2.0f + 0.5f * 2.0f)) < 1e-6);
    config.is_film_transparent = true;
    const Film film = film_of(*scene, camera_on(vec3(0.0f), 0.1f), config);
    CHECK(relative_error(pixel(film), Rgb(0.25f * 2.0f)) < 1e-6);
    CHECK(film.planes[0].values[3] == close_to(0.5, 1e-5));
}

TEST_CASE("fog dims what a mirror shows on all of its way") {
    Medium fog{.name = "fog", .lobes = {}, .sigma_a_per_m = Rgb(0.3f, 0.6f, 0.9f)};
    Material inside{.name = "fog"};
    inside.has_surface = false;
    inside.medium_index = 0;
    const Part box{.mesh = cube(), .world_from_object = glm::scale(mat4(1.0f), vec3(10.0f)), .material = inside};
    Part light = floor_at({0, 0, 3}, 5.0f, diffuse(Rgb(0.0f), Rgb(4.0f)));
    light.is_camera_visible = false;
    const auto scene = make_scene({floor_at(vec3(0.0f), 1.0f, mirror(Rgb(1.0f), Rgb(1.0f))), light, box}, {fog});
    const Rgb truth = 4.0f * glm::exp(-Rgb(0.3f, 0.6f, 0.9f) * (3.0f + 0.5f));
    const Film film = film_of(*scene, camera_on(vec3(0.0f), 0.5f), mirroring(1));
    CHECK(relative_error(pixel(film), truth) < 1e-4);
}

TEST_CASE("mirrors that are not followed are black, and named") {
    const auto scene = in_world({floor_at(vec3(0.0f), 1.0f, mirror(Rgb(0.9f), Rgb(0.9f)))}, Rgb(1.0f));
    const Film film = film_of(*scene, camera_on(vec3(0.0f), 0.1f), mirroring(0));
    CHECK(pixel(film) == Rgb(0.0f));
    REQUIRE(film.statistics.reports.size() == 1);
    CHECK(film.statistics.reports[0].find("\"mirror\" is a mirror, but mirrors are not followed") != std::string::npos);
}

TEST_CASE("a mirrored room has its light and its bounce, and its picture does not depend on threads or region") {
    Light lamp;
    lamp.name = "Lamp";
    lamp.kind = LightKind::Point;
    lamp.position = {0.2f, 0.3f, 0.8f};
    lamp.radius_m = 0.1f;
    const auto scene = in_world({{.mesh = cube(), .material = diffuse(Rgb(0.2f, 0.5f, 0.8f))},
                                 floor_at({0, 0, -0.9f}, 0.6f, mirror(Rgb(0.8f), Rgb(1.0f))),
                                 floor_at({0.4f, 0.0f, 0.0f}, 0.3f, pane(Rgb(0.5f)))},
                                Rgb(1.0f), {lamp});
    Camera camera = camera_on({0, 0, -1}, 1.5f);
    camera.window_left = camera.window_bottom = -0.9f;
    camera.window_right = camera.window_top = 0.9f;
    camera.width_px = camera.height_px = 40;
    FrameConfig config = mirroring(2);
    config.pixel_samples = 3;
    config.indirect.has_bounce = true;
    const Film one = check_whole_and_part(*scene, camera, config);
    const float* middle = &one.planes[0].values[(20 * 40 + 20) * 4];
    CHECK(middle[0] > 0.01f);
}
} // namespace mirror_test
