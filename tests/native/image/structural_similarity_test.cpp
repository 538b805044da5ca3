// SPDX-License-Identifier: GPL-3.0-or-later
// The similarity of pictures against closed forms, and against the formula written out window by window.
#include "core/errors.hpp"
#include "core/parallel.hpp"
#include "core/random.hpp"
#include "image/structural_similarity.hpp"
#include "support/close_to.hpp"
#include <cmath>
#include <doctest/doctest.h>

namespace structural_similarity_test {
using namespace tyndall;
using tyndall::support::close_to;
static constexpr double c1 = 6.5025, c2 = 58.5225; // (0.01 * 255)^2, (0.03 * 255)^2

template <typename Value>
static GreyPicture picture(std::size_t width, std::size_t height, const Value& value) {
    GreyPicture result{.width_px = width, .height_px = height, .values = {}};
    for (std::size_t y = 0; y < height; ++y)
        for (std::size_t x = 0; x < width; ++x)
            result.values.push_back(static_cast<float>(value(static_cast<double>(x), static_cast<double>(y))));
    return result;
}
static GreyPicture noise(std::size_t width, std::size_t height, std::uint32_t seed) {
    return picture(width, height, [=](double x, double y) {
        return pcg4d({static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y), seed, 1})[0] >> 24;
    });
}
/// Of the window's Gaussian over x^2, which is cut off at 5 pixels: less than 1.5^2.
static double window_variance() {
    double sum = 0.0, weights = 0.0;
    for (int x = -5; x <= 5; ++x) {
        const double weight = std::exp(-x * x / 4.5);
        sum += weight * x * x, weights += weight;
    }
    return sum / weights;
}

TEST_CASE("a picture is like itself, and no other is as much") {
    const GreyPicture one = noise(40, 30, 1);
    CHECK(structural_similarity(one, one, {}) == close_to(1.0, 1e-12));
    CHECK(structural_similarity(one, noise(40, 30, 2), {}) < 0.1);
}
TEST_CASE("even pictures differ by their means alone") {
    for (const auto& [a, b] : {std::pair{100.0, 120.0}, {0.0, 255.0}, {3.0, 200.0}}) {
        const auto of = [](double value) { return picture(16, 12, [=](double, double) { return value; }); };
        const double expected = (2 * a * b + c1) / (a * a + b * b + c1);
        CHECK(structural_similarity(of(a), of(b), {}) == close_to(expected, 1e-9));
    }
}
// Seen to fail with weights of sigma 1.6, and with K_2 = 0.02.
TEST_CASE("a ramp and one that is twice or minus as steep have the index of their slopes at each place") {
    const double variance = window_variance();
    for (const double slope : {2.0, 0.5, -1.0}) {
        const auto ramp = [](double by) {
            return picture(31, 11, [=](double x, double) { return 128.0 + by * (x - 15.0); });
        };
        double sum = 0.0;
        for (int x = 5; x <= 25; ++x) {
            const double a = 128.0 + (x - 15), b = 128.0 + slope * (x - 15);
            sum += (2 * a * b + c1) / (a * a + b * b + c1) * (2 * slope * variance + c2) /
                   ((1 + slope * slope) * variance + c2);
        }
        CHECK(structural_similarity(ramp(1.0), ramp(slope), {}) == close_to(sum / 21, 1e-9));
    }
}
TEST_CASE("what is blurred or noisy is less alike, the more so the more it is") {
    const auto waves = [](double by) {
        return picture(64, 64, [=](double x, double y) { return 128 + by * std::sin(x / 3) * std::cos(y / 4); });
    };
    const GreyPicture sharp = waves(80);
    double before = 1.0;
    for (const double left : {70.0, 40.0, 10.0, 0.0}) {
        const double alike = structural_similarity(sharp, waves(left), {});
        CHECK(alike < before);
        before = alike;
    }
    CHECK(before < 0.2);
}
TEST_CASE("the bits do not depend on the number of threads, and pictures that do not match are refused") {
    const GreyPicture a = noise(100, 90, 3), b = noise(100, 90, 4);
    const double alike = structural_similarity(a, b, {});
    for (const int threads : {1, 2, 7})
        CHECK(with_threads(threads, [&] { return structural_similarity(a, b, {}); }) == alike);
    CHECK_THROWS_WITH_AS((void)structural_similarity(a, noise(90, 100, 1), {}),
                         "similarity: a picture of 100 x 90 pixels and one of 90 x 100", InvalidInput);
    CHECK_THROWS_AS((void)structural_similarity(noise(10, 30, 1), noise(10, 30, 1), {}), InvalidInput);
}
TEST_CASE("luma is of encoded bytes") {
    const std::vector<float> pixels{1.0f, 1.0f, 1.0f, 0.0f, 0.0f, 0.0f, 0.2158605f, 0.0f, 0.0f, 9.0f, -1.0f, 0.0f};
    const GreyPicture luma = luma_of(pixels, 3, 2);
    CHECK(luma.width_px == 2);
    CHECK(luma.height_px == 2);
    const std::vector<double> expected{255.0, 0.0, 0.299 * 128, 0.299 * 255}; // 0.2159 is encoded as 128 / 255
    for (std::size_t i = 0; i < 4; ++i)
        CHECK(static_cast<double>(luma.values[i]) == close_to(expected[i], 1e-6));
}
} // namespace structural_similarity_test
