// SPDX-License-Identifier: GPL-3.0-or-later
// A wide kernel costs what a narrow one does, and fills what it should to within a twentieth of its radius.
#include "light_shafts/wide_closing.hpp"
#include "support/forest.hpp"
#include <cmath>
#include <doctest/doctest.h>
#include <vector>

namespace wide_closing_test {
using namespace tyndall;
using namespace tyndall::light_shafts;
using namespace tyndall::support;

namespace {
constexpr std::int32_t width = 500, height = 430;
/// Discs of depth 1 and 2 on nothing.
std::vector<float> make_map(std::uint64_t seed) {
    SceneRandom random(seed);
    std::vector<float> map(std::size_t{width} * height, -std::numeric_limits<float>::infinity());
    for (int disc = 0; disc < 40; ++disc) {
        const float x0 = random.uniform(0.0f, width), y0 = random.uniform(0.0f, height),
                    radius = random.uniform(2.0f, 30.0f), depth = random.uniform() < 0.5f ? 1.0f : 2.0f;
        for (std::int32_t y = 0; y < height; ++y)
            for (std::int32_t x = 0; x < width; ++x)
                if (std::hypot(static_cast<float>(x) - x0, static_cast<float>(y) - y0) < radius) {
                    float& texel = map[static_cast<std::size_t>(y * width + x)];
                    texel = std::max(texel, depth);
                }
    }
    return map;
}
std::vector<float> closed(std::vector<float> map, KernelShape shape, float radius, bool is_wide) {
    const flat_filters::MapSpan span{map.data(), width, height, width};
    if (is_wide)
        close_wide(span, shape, radius, Progress());
    else
        flat_filters::close_map(span, shape, radius, Progress());
    return map;
}
} // namespace

TEST_CASE("a wide closing takes nothing away, and lies between closings by kernels a twentieth smaller and larger") {
    for (const KernelShape shape : {KernelShape::Disc, KernelShape::Square})
        for (const float radius : {41.0f, 90.0f, 130.0f}) {
            CAPTURE(static_cast<int>(shape));
            CAPTURE(radius);
            const std::vector<float> map = make_map(7), wide = closed(map, shape, radius, true),
                                     exact = closed(map, shape, radius, false);
            std::size_t lost = 0, different = 0, filled = 0;
            for (std::size_t texel = 0; texel < map.size(); ++texel) {
                lost += wide[texel] < map[texel] ? 1 : 0;
                different += wide[texel] != exact[texel] ? 1 : 0;
                filled += exact[texel] != map[texel] ? 1 : 0;
            }
            CHECK(lost == 0);
            CHECK(filled > map.size() / 20);
            // Borders of what is filled, and places that the kernel only just fits into.
            CHECK(different < map.size() / 12);
        }
}

TEST_CASE("up to a radius of 40 texels it is the exact closing") {
    const std::vector<float> map = make_map(3);
    CHECK(closed(map, KernelShape::Disc, 40.0f, true) == closed(map, KernelShape::Disc, 40.0f, false));
    CHECK(closed(map, KernelShape::Disc, 41.0f, true) != closed(map, KernelShape::Disc, 40.0f, false));
}

TEST_CASE("a hole closes and a gap that is wider stays, at any width of the kernel") {
    for (const float radius : {60.0f, 120.0f}) {
        // A wall with a slit as wide as the kernel's radius, and all of it beside a void three times as wide.
        std::vector<float> map(std::size_t{width} * height, 1.0f);
        const auto slit = static_cast<std::int32_t>(radius);
        for (std::int32_t y = 0; y < height; ++y)
            for (std::int32_t x = 0; x < width; ++x)
                if ((x >= 20 && x < 20 + slit) || x >= 20 + slit + 20)
                    map[static_cast<std::size_t>(y * width + x)] = -std::numeric_limits<float>::infinity();
        const std::vector<float> wide = closed(map, KernelShape::Disc, radius, true);
        const std::size_t middle = std::size_t{height} / 2 * width;
        CHECK(wide[middle + 20 + static_cast<std::size_t>(slit) / 2] == 1.0f);
        const std::size_t beyond =
            middle + 40 + static_cast<std::size_t>(slit) + static_cast<std::size_t>(radius / 20) + 2;
        CHECK(!std::isfinite(wide[beyond]));
    }
}

TEST_CASE("kernels far larger than the map end") {
    std::vector<float> map = make_map(5);
    close_wide({map.data(), width, height, width}, KernelShape::Disc, 1e9f, Progress());
    CHECK(map != make_map(5));
    std::vector<float> texel{1.0f};
    close_wide({texel.data(), 1, 1, 1}, KernelShape::Square, 1e9f, Progress());
    CHECK(texel[0] == 1.0f);
}
} // namespace wide_closing_test
