// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/random.hpp"
#include "core/sampling.hpp"
#include "core/sobol.hpp"
#include "render/light_tree.hpp"
#include "support/chi_square.hpp"
#include "support/close_to.hpp"
#include <doctest/doctest.h>
#include <numbers>

namespace light_tree_test {
using namespace tyndall;
using tyndall::support::close_to;
using namespace tyndall::render;

namespace {
float number(std::uint32_t seed, std::uint32_t index) { return sobol_point(index, hash(seed)).x; }

vec3 along_an_axis(std::uint32_t index) {
    vec3 axis(0.0f);
    axis[static_cast<int>(index % 3)] = index % 2 == 0 ? 1.0f : -1.0f;
    return axis;
}

/// Points, beams and plates that glow on one side or on both, in a room of 10 m, turned any way or not at all.
std::vector<LightBounds> mixed_lights(std::uint32_t count, bool is_turned = true) {
    std::vector<LightBounds> lights;
    for (std::uint32_t index = 0; index < count; ++index) {
        LightBounds light;
        const vec3 place(number(1, index) * 10.0f, number(2, index) * 10.0f, number(3, index) * 4.0f);
        light.box.grow(place);
        light.axis = is_turned ? sample_uniform_sphere(sobol_point(index, hash(4u))) : along_an_axis(hash(index));
        light.power = 0.1f + number(5, index);
        light.spread_rad = index % 3 == 0 ? std::numbers::pi_v<float> : index % 3 == 1 ? 0.5f : 0.0f;
        light.reach_rad = index % 3 == 2 ? 0.5f * std::numbers::pi_v<float> : 0.02f;
        light.back = index % 2 == 0 && index % 3 == 2 ? 1.0f : 0.0f;
        if (index % 3 == 2)
            light.box.grow(place + vec3(0.2f, 0.1f, 0.3f));
        lights.push_back(light);
    }
    return lights;
}
} // namespace

TEST_CASE("a light tree chooses with the probabilities that it tells, which add up to 1") {
    const std::vector<LightBounds> lights = mixed_lights(300);
    const LightTree tree(lights);
    for (std::uint32_t place = 0; place < 8; ++place) {
        const vec3 point(number(7, place) * 12.0f - 1.0f, number(8, place) * 12.0f - 1.0f, number(9, place) * 4.0f);
        const vec3 normal = sample_uniform_sphere(sobol_point(place, hash(10u)));
        constexpr std::uint32_t draws = 40'000;
        std::vector<double> seen(lights.size()), expected(lights.size());
        double sum = 0.0;
        for (std::uint32_t light = 0; light < lights.size(); ++light) {
            const double probability = tree.probability(light, point, normal);
            sum += probability;
            expected[light] = probability * draws;
        }
        // A cluster may promise what none of its lights keeps.
        double drawn = 0.0;
        for (std::uint32_t draw = 0; draw < draws; ++draw) {
            const auto [light, probability] =
                tree.choose(point, normal, static_cast<float>(hash(place, draw) >> 8) * 0x1p-24f);
            if (light == LightTree::none)
                continue;
            drawn += 1.0 / draws;
            CHECK(probability == close_to(tree.probability(light, point, normal), 1e-4));
            seen[light] += 1.0;
        }
        CHECK(sum <= 1.0 + 1e-5);
        CHECK(std::abs(sum - drawn) < 0.01);
        for (double& value : expected)
            value *= drawn / sum;
        CHECK(support::is_plausible(support::chi_square_p_value(seen, expected), 8));
    }
}

TEST_CASE("points in the open are always given one of many lamps without direction: probabilities add up to 1") {
    std::vector<LightBounds> lights;
    std::uint32_t count = 0;
    SUBCASE("one branch") { count = 1000; }
    SUBCASE("many branches, which grow side by side") { count = 20'000; }
    for (std::uint32_t index = 0; index < count; ++index) {
        LightBounds light;
        light.box.grow(vec3(number(1, index), number(2, index), 1.0f + number(3, index)));
        light.spread_rad = std::numbers::pi_v<float>;
        light.power = number(4, index) + 0.01f;
        lights.push_back(light);
    }
    const LightTree tree(lights);
    const vec3 point(0.3f, 0.4f, 0.0f), normal(0, 0, 1);
    double sum = 0.0;
    for (std::uint32_t light = 0; light < lights.size(); ++light)
        sum += tree.probability(light, point, normal);
    CHECK(sum == close_to(1.0, 1e-4));
    for (std::uint32_t draw = 0; draw < 1000; ++draw) {
        const auto [light, probability] = tree.choose(point, normal, number(5, draw));
        REQUIRE(light < count);
        CHECK(probability == close_to(tree.probability(light, point, normal), 1e-4));
    }
}

TEST_CASE("no light that shines on a point is out of reach of the tree") {
    std::uint32_t count = 0, places = 0;
    bool is_turned = true;
    SUBCASE("one branch") { count = 2000, places = 20; }
    SUBCASE("one branch of lights that look along axes") { count = 2000, places = 20, is_turned = false; }
    SUBCASE("many branches, which grow side by side") { count = 20'000, places = 2; }
    const std::vector<LightBounds> lights = mixed_lights(count, is_turned);
    const LightTree tree(lights);
    for (std::uint32_t place = 0; place < places; ++place) {
        const vec3 point(number(7, place) * 10.0f, number(8, place) * 10.0f, number(9, place) * 4.0f);
        const vec3 normal = sample_uniform_sphere(sobol_point(place, hash(10u)));
        for (std::uint32_t light = 0; light < lights.size(); ++light) {
            const vec3 way = lights[light].box.centre() - point;
            const float cosine = glm::dot(glm::normalize(way), normal);
            float along = glm::dot(lights[light].axis, -glm::normalize(way));
            if (lights[light].back > 0.0f)
                along = std::abs(along);
            const float outside = std::acos(std::clamp(along, -1.0f, 1.0f)) - lights[light].spread_rad;
            if (cosine > 1e-3f && outside < 0.99f * lights[light].reach_rad)
                CHECK(tree.probability(light, point, normal) > 0.0f);
        }
    }
}
} // namespace light_tree_test
