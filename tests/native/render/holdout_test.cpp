// SPDX-License-Identifier: GPL-3.0-or-later
// Holes in the picture: what materials and objects hold out of it, what shows beside, before and around them.
#include "support/close_to.hpp"
#include "support/one_point.hpp"
#include <doctest/doctest.h>

namespace holdout_test {
using namespace tyndall;
using namespace tyndall::support;
using render::Film;
using render::FrameConfig;
using render::Pass;

namespace {
FrameConfig one_sample(bool is_film_transparent = true) {
    FrameConfig config;
    config.pixel_samples = 1;
    config.is_film_transparent = is_film_transparent;
    return config;
}
float alpha(const Film& film) { return film.find(Pass::Combined)->values[3]; }
Material holding_out(float share, const Rgb& transparent, const Rgb& emission) {
    Material material = pane(transparent);
    material.name = "hole";
    material.constant.emission = emission;
    material.constant.held_out = share;
    return material;
}
/// The first part is a held out object.
std::unique_ptr<Scene> with_hole(const std::vector<Part>& parts, std::vector<Medium> media = {},
                                 std::int32_t world_medium = -1) {
    SceneDescription description = description_of(*make_scene(parts, std::move(media)));
    description.instances[0].is_held_out = true;
    description.world = World("World", Rgb(2.0f));
    description.world_medium_index = world_medium;
    return std::make_unique<Scene>(std::move(description), Progress());
}
const Rgb glow(3.0f, 5.0f, 7.0f);
} // namespace

TEST_CASE("a material that holds out everything is a hole: black, without alpha, whatever lies behind") {
    const auto scene = in_world({floor_at({0, 0, 1}, 1.0f, holding_out(1.0f, Rgb(0.0f), Rgb(0.0f))),
                                 floor_at(vec3(0.0f), 1.0f, diffuse(Rgb(0.5f), glow))},
                                Rgb(2.0f));
    for (const bool is_transparent : {false, true}) {
        FrameConfig config = one_sample(is_transparent);
        config.passes.add(Pass::Depth);
        config.passes.add(Pass::Emission);
        const Film film = film_of(*scene, camera_on(vec3(0.0f), 2.0f), config);
        CHECK(pixel(film) == Rgb(0.0f));
        CHECK(alpha(film) == 0.0f);
        CHECK(pixel(film, Pass::Emission) == Rgb(0.0f));
        const Film bare = film_of(*in_world({}, Rgb(2.0f)), camera_on(vec3(0.0f), 2.0f), config);
        CHECK(film.find(Pass::Depth)->values[0] == bare.find(Pass::Depth)->values[0]);
    }
}

TEST_CASE("beside a share that is held out a surface shows its light, and what lies behind by what it lets through") {
    const auto scene = make_scene({floor_at({0, 0, 1}, 1.0f, holding_out(0.25f, Rgb(0.5f), Rgb(0.1f))),
                                   floor_at(vec3(0.0f), 1.0f, diffuse(Rgb(0.0f), glow))});
    for (const bool is_transparent : {false, true}) {
        const Film film = film_of(*scene, camera_on(vec3(0.0f), 2.0f), one_sample(is_transparent));
        CHECK(relative_error(pixel(film), 0.1f + 0.5f * glow) < 1e-6);
        CHECK(alpha(film) == close_to(0.75, 1e-5));
    }
}

TEST_CASE("of a held out object nothing shows but what lies behind it") {
    Part hole = floor_at({0, 0, 1}, 1.0f, holding_out(0.0f, Rgb(0.25f), Rgb(9.0f)));
    const Part floor = floor_at(vec3(0.0f), 1.0f, diffuse(Rgb(0.0f), glow));
    const Film on_floor = film_of(*with_hole({hole, floor}), camera_on(vec3(0.0f), 2.0f), one_sample());
    CHECK(relative_error(pixel(on_floor), 0.25f * glow) < 1e-6);
    CHECK(alpha(on_floor) == close_to(0.25, 1e-5));
    const Film in_sky = film_of(*with_hole({hole}), camera_on(vec3(0.0f), 2.0f), one_sample());
    CHECK(pixel(in_sky) == Rgb(0.0f));
    CHECK(alpha(in_sky) == close_to(0.0, 1e-6));
    const Film before_sky = film_of(*with_hole({hole}), camera_on(vec3(0.0f), 2.0f), one_sample(false));
    CHECK(relative_error(pixel(before_sky), Rgb(0.5f)) < 1e-6);
    CHECK(alpha(before_sky) == close_to(0.25, 1e-5));
}

TEST_CASE("air before a held out object shows as before a black one, and covers by what it stops") {
    const Medium smoke{
        .name = "smoke", .lobes = {}, .sigma_a_per_m = Rgb(0.5f), .emission_w_per_m3_sr = Rgb(0.1f, 0.2f, 0.3f)};
    const Part black = floor_at(vec3(0.0f), 1.0f, diffuse(Rgb(0.0f)));
    const auto in_smoke = [&](bool is_held_out) {
        SceneDescription description = description_of(*make_scene({black}, {smoke}));
        description.instances[0].is_held_out = is_held_out;
        description.world_medium_index = 0;
        return film_of(Scene(std::move(description), Progress()), camera_on(vec3(0.0f), 2.0f), one_sample());
    };
    const Film hole = in_smoke(true), surface = in_smoke(false);
    CHECK(pixel(hole) == pixel(surface));
    CHECK(pixel(hole).z > 0.1f);
    CHECK(alpha(surface) == 1.0f);
    const double length_m = 2.0 - 1e-4; // behind the near clip
    CHECK(alpha(hole) == close_to(1.0 - std::exp(-0.5 * length_m), 1e-6));
}

TEST_CASE("mirrors show what cameras do not: a held out object is there") {
    Material silver = diffuse(Rgb(0.0f));
    silver.gloss = GlossLayers{.constant = {.facing = Rgb(1.0f), .edge = Rgb(1.0f)}};
    Part above = floor_at({0, 0, 3}, 1.0f, diffuse(Rgb(0.0f), glow));
    FrameConfig config = one_sample();
    config.indirect.mirror_depth = 1;
    const Film film =
        film_of(*with_hole({above, floor_at(vec3(0.0f), 1.0f, silver)}), camera_on(vec3(0.0f), 2.0f), config);
    CHECK(relative_error(pixel(film), glow) < 1e-6);
    CHECK(alpha(film) == 1.0f);
}

TEST_CASE("a program's share is held out as a constant's, within 0 and 1, and stops light") {
    Material material{.name = "program"};
    material.program = {{.code = SurfaceOp::Code::Constant, .out = 0, .value = Rgb(0.0f)},
                        {.code = SurfaceOp::Code::Constant, .out = 1, .value = Rgb(4.0f)}};
    material.held_out_register = 1;
    const auto scene = in_world({floor_at(vec3(0.0f), 1.0f, material)}, Rgb(2.0f));
    CHECK(alpha(film_of(*scene, camera_on(vec3(0.0f), 2.0f), one_sample())) == 0.0f);
    material.program[1].value = Rgb(0.125f);
    const auto partly = in_world({floor_at(vec3(0.0f), 1.0f, material)}, Rgb(2.0f));
    CHECK(alpha(film_of(*partly, camera_on(vec3(0.0f), 2.0f), one_sample())) == 0.875f);
}
} // namespace holdout_test
