// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/errors.hpp"
#include "core/parallel.hpp"
#include "native/voxel_dag/attribute_sequences.hpp"
#include "voxel_dag/color_palette.hpp"
#include <algorithm>
#include <doctest/doctest.h>
#include <set>

namespace color_palette_test {
using namespace tyndall;
using namespace tyndall::voxel_dag;

TEST_CASE("sRGB primaries, white and grey have the CIELAB coordinates that are published for D65") {
    struct Known {
        PackedColor color;
        Lab lab;
    };
    // B. Lindbloom's calculator, sRGB, D65.
    for (const auto& [color, lab] : {Known{0xffffff, {100.0, 0.0, 0.0}}, Known{0x000000, {0.0, 0.0, 0.0}},
                                     Known{0xff0000, {53.24, 80.09, 67.20}}, Known{0x00ff00, {87.73, -86.18, 83.18}},
                                     Known{0x0000ff, {32.30, 79.19, -107.86}}, Known{0x808080, {53.59, 0.0, 0.0}}}) {
        const Lab found = lab_of(color);
        CAPTURE(color);
        CHECK(std::abs(found.lightness - lab.lightness) < 0.02);
        CHECK(std::abs(found.a - lab.a) < 0.02);
        CHECK(std::abs(found.b - lab.b) < 0.02);
    }
}

TEST_CASE("a colour goes to CIELAB and back") {
    for (PackedColor color = 0; color < 1u << 24; color += 997)
        REQUIRE(color_of(lab_of(color)) == color);
}

/// From the polar angle of hue: another way to the same number.
static double cie94_by_hue_angle(const Lab& first, const Lab& second) {
    const double c1 = std::hypot(first.a, first.b), c2 = std::hypot(second.a, second.b);
    const double hue =
        2.0 * std::sqrt(c1 * c2) * std::sin(0.5 * (std::atan2(first.b, first.a) - std::atan2(second.b, second.a)));
    return std::hypot(first.lightness - second.lightness, (c1 - c2) / (1.0 + 0.045 * c1), hue / (1.0 + 0.015 * c1));
}

TEST_CASE("CIE94 is the published value, and that of an independent formula, and is not symmetric") {
    // The example of colour-science's delta_E_CIE1994, constants of graphic arts.
    const Lab first{100.0, 21.57210357, 272.22819350}, second{100.0, 426.67945353, 72.39590835};
    CHECK(std::abs(cie94(first, second) - 83.7792255) < 1e-6);
    CHECK(std::abs(cie94(second, first) - cie94(first, second)) > 1.0);
    test::Random random(1);
    for (int i = 0; i < 2000; ++i) {
        const Lab a = lab_of(random() & 0xffffff), b = lab_of(random() & 0xffffff);
        REQUIRE(std::abs(cie94(a, b) - cie94_by_hue_angle(a, b)) < 1e-6);
    }
    CHECK(cie94(first, first) == 0.0);
}

/// Ramps and noise: shades that change slowly, as of a lit surface, and a few that do not.
static std::vector<PackedColor> shades(std::size_t count, std::uint32_t seed) {
    test::Random random(seed);
    std::vector<PackedColor> colors;
    for (std::size_t i = 0; i < count; ++i) {
        const auto at = static_cast<std::uint32_t>(i * 255 / count);
        const std::uint32_t noise = random() % 24;
        colors.push_back(i % 3 == 0 ? 0x804020 + noise * 0x010203
                                    : at << 16 | (at / 2 + noise) << 8 | (random() % 8 == 0 ? 255 - at : at));
    }
    return colors;
}

// Seen to fail with means that colours move to without a look at who gets worse.
TEST_CASE("no entry is further from its colour than was chosen") {
    for (const double most_difference : {0.01, 0.5, 1.0, 2.3, 10.0, 100.0})
        for (const auto& entries : {shades(20000, 1), test::random_runs(5000, 1u << 24, 30, 2)}) {
            CAPTURE(most_difference);
            const color_palette::Result result = color_palette::within(entries, most_difference, {});
            REQUIRE(result.indices.size() == entries.size());
            double most = 0.0, sum = 0.0;
            for (std::size_t i = 0; i < entries.size(); ++i) {
                const double difference = cie94(lab_of(entries[i]), lab_of(result.colors[result.indices[i]]));
                REQUIRE(difference <= most_difference * (1.0 + 1e-12));
                most = std::max(most, difference), sum += difference;
            }
            CHECK(result.statistics.most_difference == most);
            CHECK(std::abs(result.statistics.mean_difference - sum / static_cast<double>(entries.size())) < 1e-9);
            CHECK(std::ranges::is_sorted(result.colors));
        }
}

TEST_CASE("a palette has no more colours than asked for, all that there are if they fit, and gets better as it grows") {
    const std::vector<PackedColor> entries = shades(20000, 3);
    const std::set<PackedColor> different(entries.begin(), entries.end());
    double mean_before = 1e9, most_before = 1e9;
    for (const std::uint32_t count : {1u, 4u, 16u, 64u, 256u, 1024u, 65536u}) {
        CAPTURE(count);
        const color_palette::Result result = color_palette::of_size(entries, count, {});
        REQUIRE(result.colors.size() <= count);
        CHECK(result.statistics.mean_difference < mean_before);
        CHECK(result.statistics.most_difference < most_before);
        mean_before = result.statistics.mean_difference, most_before = result.statistics.most_difference;
    }
    CHECK(color_palette::of_size(entries, 65536, {}).colors ==
          std::vector<PackedColor>(different.begin(), different.end()));
    CHECK(mean_before == 0.0);
    CHECK(most_before == 0.0);
}

TEST_CASE("palettes do not depend on the number of threads, and take no entries at all") {
    const std::vector<PackedColor> entries = test::random_runs(60000, 1u << 24, 0, 4);
    const auto of_size = color_palette::of_size(entries, 64, {}), within = color_palette::within(entries, 6.0, {});
    for (const int threads : {1, 2, 7})
        with_threads(threads, [&] {
            CHECK(color_palette::of_size(entries, 64, {}).indices == of_size.indices);
            CHECK(color_palette::of_size(entries, 64, {}).colors == of_size.colors);
            CHECK(color_palette::within(entries, 6.0, {}).indices == within.indices);
            CHECK(color_palette::within(entries, 6.0, {}).colors == within.colors);
        });
    CHECK(color_palette::of_size({}, 16, {}).colors.empty());
    CHECK(color_palette::within({}, 1.0, {}).colors.empty());
}

TEST_CASE("an entry that is no colour is named, and so are palettes and differences that are not possible") {
    CHECK_THROWS_WITH_AS(color_palette::of_size(std::vector<PackedColor>{1, 1u << 24}, 4, {}),
                         "entry 1 is no colour of 24 bits", InvalidInput);
    CHECK_THROWS_AS(color_palette::of_size({}, 0, {}), InvalidInput);
    CHECK_THROWS_AS(color_palette::of_size({}, 65537, {}), InvalidInput);
    CHECK_THROWS_AS(color_palette::within({}, 0.0, {}), InvalidInput);
    CHECK_THROWS_AS(color_palette::within({}, std::nan(""), {}), InvalidInput);
}
} // namespace color_palette_test
