// SPDX-License-Identifier: GPL-3.0-or-later
// How much of the world a point sees, against closed forms: beside a wall, below a disc, in a box and on a plain.
#include "support/close_to.hpp"
#include "support/one_point.hpp"
#include <doctest/doctest.h>

namespace ambient_occlusion_test {
using namespace tyndall;
using namespace tyndall::support;
using render::Film;
using render::FrameConfig;
using render::Pass;

namespace {
/// Of 4,096 Owen-scrambled points of a Sobol sequence against a straight or round edge: some 1e-3.
constexpr double sampling_error = 3e-3;

FrameConfig config_with(float distance_m) {
    FrameConfig config;
    config.pixel_samples = 1024;
    config.passes.add(Pass::AmbientOcclusion);
    config.indirect.ambient_distance_m = distance_m;
    config.indirect.ambient_samples = 4;
    config.adapts_shadow_rays = false;
    return config;
}
float seen_at(const Scene& scene, const vec3& place, float distance_m = 0.0f) {
    return pixel(film_of(scene, camera_on(place, 0.05f), config_with(distance_m)), Pass::AmbientOcclusion).x;
}
/// A wall across x = 0 that reaches 10 km to each side, and that high, beside a floor as large.
std::vector<Part> wall_and_floor(float height_m) {
    mat4 upright(1.0f);
    upright[0] = {0, 0, 0.5f * height_m, 0};
    upright[1] = {0, 1e4f, 0, 0};
    upright[2] = {1, 0, 0, 0};
    upright[3] = {0, 0, 0.5f * height_m, 1};
    return {floor_at(vec3(0.0f), 1e4f, diffuse(Rgb(0.5f))),
            {.mesh = square(), .world_from_object = upright, .material = diffuse(Rgb(0.5f))}};
}
/// Share of the unit disc on the near side of a chord that far from its centre: rays by the cosine are even on it.
double share_before_chord(double from_centre) {
    return 1.0 - (std::acos(from_centre) - from_centre * std::sqrt(1.0 - from_centre * from_centre)) / std::numbers::pi;
}
} // namespace

TEST_CASE("beside an endless wall a floor sees half of the world, and all of it but a segment within a distance") {
    const auto scene = make_scene(wall_and_floor(1e4f));
    CHECK(std::abs(seen_at(*scene, {0.3f, 0, 0}) - 0.5) < sampling_error);
    // A ray meets the wall within d where its share across is more than x / d, whatever its height.
    for (const float distance_m : {0.2f, 0.4f, 1.0f, 3.0f}) {
        CAPTURE(distance_m);
        const double truth = share_before_chord(std::min(1.0, 0.3 / double{distance_m}));
        CHECK(std::abs(seen_at(*scene, {0.3f, 0, 0}, distance_m) - truth) < sampling_error);
    }
}

TEST_CASE("a long wall of some height hides what its form factor says") {
    for (const double height : {0.1, 1.0, 5.0}) {
        const auto scene = make_scene(wall_and_floor(static_cast<float>(height)));
        const double truth = 1.0 - 0.5 * (1.0 - 0.5 / std::hypot(0.5, height));
        CHECK(std::abs(seen_at(*scene, {0.5f, 0, 0}) - truth) < sampling_error);
    }
}

TEST_CASE("a disc above a point hides r^2 / (r^2 + h^2) of it, a pane of glass its opaque share of that") {
    for (const double radius : {0.2, 1.0, 3.0})
        for (const Rgb passing : {Rgb(0.0f), Rgb(0.25f, 0.5f, 1.0f)}) {
            const auto scene = make_scene({floor_at(vec3(0.0f), 2.0f, diffuse(Rgb(0.5f))),
                                           {.mesh = disc(static_cast<float>(radius)),
                                            .world_from_object = translation({0, 0, 0.5f}),
                                            .material = pane(passing)}});
            const double hidden = radius * radius / (radius * radius + 0.25);
            const Film film = film_of(*scene, camera_on(vec3(0.0f), 0.05f), config_with(0.0f));
            const glm::dvec3 truth = 1.0 - hidden * (1.0 - glm::dvec3(passing));
            CHECK(glm::length(glm::dvec3(pixel(film, Pass::AmbientOcclusion)) - truth) < 2 * sampling_error);
        }
}

TEST_CASE("inside a closed box nothing of the world is seen; on a plain, or in a hall larger than the distance, all") {
    const Part box{.mesh = cube(), .material = diffuse(Rgb(1.0f))};
    const vec3 on_its_floor(0.1f, 0.2f, -1.0f);
    CHECK(seen_at(*make_scene({box}), on_its_floor) == 0.0f);
    CHECK(seen_at(*make_scene({box}), on_its_floor, 0.5f) == 1.0f);
    CHECK(seen_at(*make_scene({floor_at(vec3(0.0f), 1.0f, diffuse(Rgb(0.0f)))}), vec3(0.0f)) == 1.0f); // black, too
}

TEST_CASE("where a pixel is covered in part, so is the pass; where nothing is, it is 0") {
    const auto scene = make_scene({floor_at(vec3(0.0f), 1.0f, pane(Rgb(0.25f)))});
    CHECK(seen_at(*scene, vec3(0.0f)) == close_to(0.75, 1e-5));
    CHECK(seen_at(*scene, {5, 5, 0}) == 0.0f);
}

TEST_CASE("with a distance the world lights surfaces past what stands farther away: albedo, times radiance, times AO") {
    const Rgb radiance(2.0f, 1.0f, 0.5f), albedo(0.5f);
    const auto scene = in_world(wall_and_floor(1e4f), radiance);
    for (const float distance_m : {0.0f, 0.4f, 1.0f}) {
        FrameConfig config = config_with(distance_m);
        config.indirect.has_ambient_occlusion = true;
        const Film film = film_of(*scene, camera_on({0.3f, 0, 0}, 0.05f), config);
        const double seen = distance_m == 0.0f ? 0.5 : share_before_chord(0.3 / double{distance_m});
        const Rgb truth = static_cast<float>(seen) * radiance * albedo;
        CHECK(relative_error(pixel(film), truth) < 2 * sampling_error);
        CHECK(std::abs(pixel(film, Pass::AmbientOcclusion).x - seen) < sampling_error);
    }
}

TEST_CASE("without it the distance changes nothing of the picture") {
    const auto scene = in_world(wall_and_floor(1.0f), Rgb(1.0f));
    const Camera camera = camera_on({0.3f, 0, 0}, 0.05f);
    CHECK(film_of(*scene, camera, config_with(0.4f)).planes[0].values ==
          film_of(*scene, camera, config_with(0.0f)).planes[0].values);
}

TEST_CASE("a distance or a number of rays that is none is refused by name") {
    const auto scene = make_scene({floor_at(vec3(0.0f), 1.0f, diffuse(Rgb(0.5f)))});
    const auto film_with = [&](float distance_m, std::uint32_t samples) {
        FrameConfig config = config_with(distance_m);
        config.indirect.ambient_samples = samples;
        return film_of(*scene, camera_on(vec3(0.0f), 0.05f), config);
    };
    CHECK_THROWS_WITH_AS(film_with(-1.0f, 1), doctest::Contains("ambient_distance_m"), InvalidInput);
    CHECK_THROWS_WITH_AS(film_with(std::nanf(""), 1), doctest::Contains("ambient_distance_m"), InvalidInput);
    CHECK_THROWS_WITH_AS(film_with(1.0f, 0), doctest::Contains("ambient_samples is 0"), InvalidInput);
}
} // namespace ambient_occlusion_test
