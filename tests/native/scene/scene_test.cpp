// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/scene.hpp"
#include "support/scenes.hpp"
#include <doctest/doctest.h>

using namespace tyndall;
using namespace tyndall::support;

TEST_CASE("a ray meets the nearest surface, at its distance, with the normal that its winding says") {
    const auto scene = make_scene({{.mesh = square(), .world_from_object = translation({0, 0, 1})},
                                   {.mesh = square(), .world_from_object = translation({0, 0, 2})}});
    const Hit hit = scene->closest_hit({.origin = {0.1f, 0.2f, 5}, .direction = {0, 0, -1}});
    CHECK(hit.is_hit());
    CHECK(hit.instance == 1);
    CHECK(hit.distance_m == 3.0f);
    CHECK(hit.geometric_normal == vec3(0, 0, 1));
}
TEST_CASE("a mirrored instance keeps its normal outside") {
    const mat4 mirror = glm::scale(mat4(1.0f), vec3(-2, 1, 1));
    const auto scene = make_scene({{.mesh = square(), .world_from_object = mirror}});
    CHECK(scene->closest_hit({.origin = {0, 0.1f, 5}, .direction = {0, 0, -1}}).geometric_normal == vec3(0, 0, 1));
}
TEST_CASE("a fog box is never met, neither by the camera nor by a shadow ray") {
    Material fog{.name = "fog", .medium_index = 0, .has_surface = false};
    const auto scene = make_scene({{.mesh = square(), .material = fog}}, {Medium{.name = "fog"}});
    const Ray ray{.origin = {0, 0, 5}, .direction = {0, 0, -1}};
    CHECK(!scene->closest_hit(ray).is_hit());
    CHECK(scene->shadow_transmittance(ray) == Rgb(1.0f));
    CHECK(scene->surface_bounds().is_empty());
    CHECK(!scene->bounds().is_empty());
}
TEST_CASE("transparent surfaces multiply, an opaque one ends the ray") {
    const auto glass = [](Rgb transparent) {
        return Material{.name = "glass", .constant = {.diffuse_albedo = Rgb(0.0f), .transparent = transparent}};
    };
    const Ray down{.origin = {0.1f, 0.2f, 5}, .direction = {0, 0, -1}};
    const Part red{.mesh = square(), .world_from_object = translation({0, 0, 1}), .material = glass({0.5f, 0.25f, 0})};
    const Part grey{.mesh = square(), .world_from_object = translation({0, 0, 2}), .material = glass(Rgb(0.5f))};
    const Part wall{.mesh = square(), .world_from_object = translation({0, 0, 3})};
    CHECK(make_scene({red, grey})->shadow_transmittance(down) == Rgb(0.25f, 0.125f, 0));
    CHECK(make_scene({red, wall, grey})->shadow_transmittance(down) == Rgb(0.0f));
}
