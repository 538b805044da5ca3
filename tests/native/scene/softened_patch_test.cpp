// SPDX-License-Identifier: GPL-3.0-or-later
// Outlines of area lights against closed forms of their solid angles, and patches against the light they are patches of.
#include "scene/softened_patch.hpp"
#include "support/area_lights.hpp"
#include "support/forest.hpp"
#include <doctest/doctest.h>

namespace softened_patch_test {
using namespace tyndall;

TEST_CASE("a rectangle's outline is seen under its solid angle, from anywhere before it") {
    support::SceneRandom random(3);
    for (int index = 0; index < 500; ++index) {
        const vec2 half(random.uniform(0.01f, 3.0f), random.uniform(0.01f, 3.0f));
        const dvec2 foot(random.uniform(-5.0f, 5.0f), random.uniform(-5.0f, 5.0f));
        const double height = std::pow(10.0, random.uniform(-4.0f, 3.0f));
        CAPTURE(height);
        const double closed = 0.5 * rectangle_solid_angle_sr(-dvec2(half) - foot, dvec2(half) - foot, height);
        const double ours = half_solid_angle_sr(area_outline(support::area_light(half)), foot, height);
        CHECK(std::abs(ours - closed) < 1e-9 + 1e-6 * closed);
    }
}
TEST_CASE("an ellipse's outline is as large as it is, and a disc's is seen under the angle of its cap to 1 %") {
    for (const vec2 half : {vec2(1.0f, 1.0f), vec2(2.0f, 0.3f)}) {
        Light light = support::area_light(half);
        light.is_ellipse = true;
        const AreaOutline outline = area_outline(light);
        double twice_area = 0.0;
        for (std::size_t corner = 0; corner < outline.count; ++corner) {
            const vec2 a = outline.corners_m[corner], b = outline.corners_m[(corner + 1) % outline.count];
            twice_area += double{a.x} * b.y - double{a.y} * b.x;
        }
        CHECK(std::abs(0.5 * twice_area / area_m2(light) - 1.0) < 1e-6);
        if (half.x == half.y)
            for (const double height : {0.01, 0.3, 1.0, 10.0}) {
                const double cap = std::numbers::pi * (1.0 - height / std::hypot(height, 1.0));
                CHECK(std::abs(half_solid_angle_sr(outline, dvec2(0.0), height) / cap - 1.0) < 0.01);
            }
    }
}
TEST_CASE("far from a light its patches are points, and beside its plane next to its edge they give nothing") {
    const Light light = support::area_light({1.0f, 0.5f});
    LightSample patch = sample_light(light, 0, {0.3f, 0.6f, 0.0f});
    patch.softening_m2 = area_m2(light) * std::numbers::inv_pi_v<float> / 64.0f;
    const vec3 afar = support::before(light, {3.0f, -2.0f}, 200.0f), way = afar - patch.position;
    const LocalView view = view_local(patch, afar);
    const double closed = double{patch.strength.x} * glm::dot(way, light.spot_axis) / std::pow(glm::length(way), 3.0f);
    CHECK(std::abs(view.irradiance.x / closed - 1.0) < 1e-3);
    CHECK(glm::length(view.from_light - glm::normalize(way)) < 1e-4f);
    CHECK(std::abs(view.distance_m / glm::length(way) - 1.0f) < 1e-4f);
    const auto at = [&](float aside) {
        return view_local(patch, support::before(light, {aside, 0.0f}, 1e-4f)).irradiance.x;
    };
    CHECK(at(1.05f) < 0.01f * at(0.95f));
}
} // namespace softened_patch_test
