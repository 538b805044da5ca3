// SPDX-License-Identifier: GPL-3.0-or-later
// Cells with normals of their own: lit where those are, and shadowed by others alone.
#include "render/shadow_terminator.hpp"
#include "support/box_shape.hpp"
#include <doctest/doctest.h>

using namespace tyndall;
using namespace tyndall::support;

/// What light passes to the face of cell 0 that looks along x.
static Rgb passing(std::vector<glm::ivec3> cells, const vec3& normal, const vec3& towards_light) {
    const auto shape = std::make_shared<const BoxShape>(std::move(cells), 1.0f, 0, normal);
    const mat4 place = glm::scale(translation({20.0f, -7.0f, 3.0f}), vec3(0.5f));
    const auto scene = BoxScene{.places = {place}}.scene(shape, false);
    const Ray view{.origin = {23.0f, -6.75f, 3.25f}, .direction = {-1, 0, 0}};
    const Hit hit = scene->closest_hit(view);
    REQUIRE(hit.is_hit());
    const vec3 lift = render::terminator_lift(*scene, hit, scene->shading_point(view, hit), towards_light);
    Ray ray = scene->leaving_ray(hit, towards_light);
    ray.origin += lift;
    return scene->shadow_transmittance(ray);
}

TEST_CASE("a cell whose normal is lit does not shadow itself, and its neighbours shadow it") {
    const vec3 normal = glm::normalize(vec3(0.3f, 0.0f, 1.0f)), light = glm::normalize(vec3(-0.6f, 0.1f, 0.8f));
    CHECK(passing({{0, 0, 0}}, normal, light) == Rgb(1.0f));
    CHECK(passing({{0, 0, 0}, {0, 0, 1}}, normal, light) == Rgb(0.0f));
    CHECK(passing({{0, 0, 0}, {-3, 0, 4}}, normal, light) == Rgb(0.0f)); // some way off
    CHECK(passing({{0, 0, 0}, {0, 0, -1}}, normal, light) == Rgb(1.0f));
}

TEST_CASE("a cell without a normal, or whose normal looks away, is dark behind its face") {
    const vec3 light = glm::normalize(vec3(-0.6f, 0.1f, 0.8f));
    CHECK(passing({{0, 0, 0}}, vec3(0.0f), light) == Rgb(0.0f));
    CHECK(passing({{0, 0, 0}}, glm::normalize(vec3(1.0f, 0.0f, -0.2f)), light) == Rgb(0.0f));
}
