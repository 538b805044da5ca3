// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/op_photometry.hpp"
#include <cmath>
#include <doctest/doctest.h>
#include <numbers>
#include <vector>

namespace photometry_test {
using namespace tyndall;

namespace {
constexpr float pi = std::numbers::pi_v<float>;
/// So many angles all around and from pole to pole, evenly apart; values of both.
template <typename Value>
std::vector<vec4> table(int across, int down, const Value& value) {
    std::vector<vec4> values{vec4(static_cast<float>(across), static_cast<float>(down), 0, 0)};
    const auto longitude = [&](int h) { return 2.0f * pi * static_cast<float>(h) / static_cast<float>(across - 1); };
    const auto latitude = [&](int v) { return pi * static_cast<float>(v) / static_cast<float>(down - 1); };
    for (int h = 0; h < across; ++h)
        values.emplace_back(longitude(h), 0, 0, 0);
    for (int v = 0; v < down; ++v)
        values.emplace_back(latitude(v), 0, 0, 0);
    for (int h = -1; h <= across; ++h)
        for (int v = 0; v + 1 < down; ++v) {
            vec4 four;
            for (int beside = 0; beside < 4; ++beside)
                four[beside] = value(longitude(h), latitude(v + beside - 1));
            values.push_back(four);
        }
    return values;
}
} // namespace

TEST_CASE("a luminaire that sends the same everywhere has one value") {
    const std::vector<vec4> even = table(5, 7, [](float, float) { return 3.5f; });
    REQUIRE(is_photometry(even));
    for (const vec3& way : {vec3(0, 0, -1), vec3(1, 2, 0.5f), vec3(-3, 1, -20), vec3(0.01f, -2, 1)})
        CHECK(std::abs(photometric_value(even, way) - 3.5f) < 1e-6f);
}
// Catmull and Rom's curves keep parabolas. Seen to fail with straight lines.
TEST_CASE("angles are counted from straight down and from behind, and squares of them are kept") {
    const std::vector<vec4> square = table(9, 7, [](float h, float v) { return h * h + 2.0f * v * v; });
    for (const float v : {0.3f, 1.4f, 2.9f})
        for (const float h : {0.2f, 1.9f, 4.4f, 6.2f}) {
            const float x = std::sin(v) * std::sin(h - pi), y = std::sin(v) * std::cos(h - pi);
            CHECK(std::abs(photometric_value(square, 2.5f * vec3(x, y, -std::cos(v))) / (h * h + 2.0f * v * v) - 1.0f) <
                  1e-5f);
        }
}
TEST_CASE("there is nothing outside of its angles, and never less than nothing") {
    std::vector<vec4> half = table(5, 7, [](float, float v) { return v < 1.0f ? -1.0f : 2.0f; });
    for (int v = 0; v < 7; ++v)
        half[static_cast<std::size_t>(1 + 5 + v)].x *= 0.5f;
    REQUIRE(is_photometry(half));
    CHECK(photometric_value(half, {0.1f, 0, 1}) == 0.0f);
    CHECK(photometric_value(half, {0, 0.01f, -1}) == 0.0f);
    CHECK(photometric_value(half, {0, 1, -0.3f}) > 1.0f);
}
TEST_CASE("a table that is none is refused") {
    const std::vector<vec4> good = table(3, 3, [](float, float) { return 1.0f; });
    for (const std::size_t kept : {0, 1, 5, 12})
        CHECK_FALSE(is_photometry(std::span(good).first(kept)));
    for (const vec4& head : {vec4(1, 3, 0, 0), vec4(3, 1e9f, 0, 0), vec4(-3, 3, 0, 0), vec4(std::nanf(""), 3, 0, 0)}) {
        std::vector<vec4> other = good;
        other[0] = head;
        CHECK_FALSE(is_photometry(other));
    }
    std::vector<vec4> falling = good;
    std::swap(falling[1], falling[2]);
    CHECK_FALSE(is_photometry(falling));
}
} // namespace photometry_test
