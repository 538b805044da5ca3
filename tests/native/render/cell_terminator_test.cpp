// SPDX-License-Identifier: GPL-3.0-or-later
// Cells with normals of their own: lit where those are, and shadowed by others alone.
#include "render/shadow_terminator.hpp"
#include "support/box_shape.hpp"
#include <cmath>
#include <doctest/doctest.h>

namespace cell_terminator_test {
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

TEST_CASE("a cell whose normal is lit does not shadow itself; what stands beyond its steps shadows it") {
    const vec3 normal = glm::normalize(vec3(0.3f, 0.0f, 1.0f)), light = glm::normalize(vec3(-0.6f, 0.1f, 0.8f));
    CHECK(passing({{0, 0, 0}}, normal, light) == Rgb(1.0f));
    CHECK(passing({{0, 0, 0}, {0, 0, 2}}, normal, light) == Rgb(0.0f));
    CHECK(passing({{0, 0, 0}, {-3, 1, 6}}, normal, light) == Rgb(0.0f)); // some way off
    CHECK(passing({{0, 0, 0}, {0, 0, -1}}, normal, light) == Rgb(1.0f));
}

TEST_CASE("the steps of a thin surface cast no shadow on it, and a wall upon it does") {
    for (const vec3& across : {vec3(0.3f, 0.2f, 1.0f), vec3(0.9f, 0.8f, 1.0f), vec3(0.0f, 0.0f, 1.0f)}) {
        const vec3 normal = glm::normalize(across);
        std::vector<glm::ivec3> cells;
        for (int x = -12; x <= 12; ++x)
            for (int y = -12; y <= 12; ++y) { // by the rule of columns along z, the main axis
                const float height = across.x * static_cast<float>(x) + across.y * static_cast<float>(y);
                cells.push_back({x, y, static_cast<int>(std::lround(-height))});
            }
        const auto shape = std::make_shared<const BoxShape>(cells, 1.0f, 0, normal);
        const auto plane = BoxScene{.places = {mat4(1.0f)}}.scene(shape, false);
        std::vector<glm::ivec3> with_wall = cells;
        const glm::ivec3 foot = cells[25 * 2 + 12]; // at x = -10
        for (int y = -12; y <= 12; ++y)
            for (int z = 1; z <= 14; ++z)
                with_wall.push_back({foot.x, y, cells[25 * 2 + static_cast<std::size_t>(y + 12)].z + z});
        const auto walled =
            BoxScene{.places = {mat4(1.0f)}}.scene(std::make_shared<const BoxShape>(with_wall, 1.0f, 0, normal), false);
        const vec3 along = glm::normalize(glm::cross(vec3(0, 1, 0), normal)); // up x
        for (const float sine : {0.05f, 0.3f, 0.9f}) {
            const vec3 light = sine * normal - std::sqrt(1.0f - sine * sine) * along;
            std::size_t shadowed_by_wall = 0;
            for (int i = 0; i < 64; ++i) {
                const vec3 at(static_cast<float>(i % 8) * 0.63f - 2.2f, static_cast<float>(i) / 13.0f - 2.3f, 0.0f);
                const vec3 target = at + vec3(0, 0, 0.5f - (across.x * at.x + across.y * at.y));
                const Ray view{.origin = target + 30.0f * normal, .direction = -normal};
                const auto shown = [&](const Scene& scene) {
                    const Hit hit = scene.closest_hit(view);
                    REQUIRE(hit.is_hit());
                    Ray ray = scene.leaving_ray(hit, light);
                    ray.origin += render::terminator_lift(scene, hit, scene.shading_point(view, hit), light);
                    return scene.shadow_transmittance(ray);
                };
                CHECK(shown(*plane) == Rgb(1.0f));
                shadowed_by_wall += shown(*walled) == Rgb(0.0f) ? 1 : 0;
            }
            CHECK(shadowed_by_wall == (sine < 0.5f ? 64 : 0));
        }
    }
}

TEST_CASE("a cell without a normal, or whose normal looks away, is dark behind its face") {
    const vec3 light = glm::normalize(vec3(-0.6f, 0.1f, 0.8f));
    CHECK(passing({{0, 0, 0}}, vec3(0.0f), light) == Rgb(0.0f));
    CHECK(passing({{0, 0, 0}}, glm::normalize(vec3(1.0f, 0.0f, -0.2f)), light) == Rgb(0.0f));
}
} // namespace cell_terminator_test
