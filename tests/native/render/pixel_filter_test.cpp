// SPDX-License-Identifier: GPL-3.0-or-later
// Drawing sample positions from the filter is the filter: moments and densities must agree with its formula.
#include "core/errors.hpp"
#include "render/pixel_filter.hpp"
#include <array>
#include <cmath>
#include <doctest/doctest.h>
#include <limits>

namespace pixel_filter_test {
using tyndall::render::FilterSampler;
using tyndall::render::PixelFilter;

namespace {
constexpr std::array all_filters{PixelFilter::Box, PixelFilter::Gaussian, PixelFilter::BlackmanHarris};

/// Mean of |offset|^power over equally spaced u: the sampler's own moment.
double sampled_moment(const FilterSampler& filter, int power) {
    constexpr int count = 1 << 16;
    double sum = 0.0;
    for (int i = 0; i < count; ++i)
        sum += std::pow(filter.offset_px({(static_cast<float>(i) + 0.5f) / count, 0.5f}).x, power);
    return sum / count;
}
/// The same from the density, by the midpoint rule.
double integrated_moment(const FilterSampler& filter, int power) {
    constexpr int count = 1 << 14;
    const double step = 2.0 * filter.radius_px() / count;
    double sum = 0.0;
    for (int i = 0; i < count; ++i) {
        const double x = -filter.radius_px() + (i + 0.5) * step;
        sum += std::pow(x, power) * filter.density_per_px(static_cast<float>(x)) * step;
    }
    return sum;
}
} // namespace

TEST_CASE("a filter's density integrates to 1 and its samples have its moments") {
    for (const PixelFilter kind : all_filters)
        for (const float width_px : {0.01f, 1.0f, 1.5f, 10.0f}) {
            CAPTURE(static_cast<int>(kind));
            CAPTURE(width_px);
            const FilterSampler filter(kind, width_px);
            CHECK(std::abs(integrated_moment(filter, 0) - 1.0) < 1e-5);
            CHECK(std::abs(sampled_moment(filter, 1)) < 1e-5 * width_px);
            CHECK(std::abs(sampled_moment(filter, 2) / integrated_moment(filter, 2) - 1.0) < 1e-4);
            // The last of 1024 linear steps carries the tail: 3e-4 of the fourth moment of a Gaussian.
            CHECK(std::abs(sampled_moment(filter, 4) / integrated_moment(filter, 4) - 1.0) < 5e-4);
        }
}

TEST_CASE("the widths mean what they mean in Cycles") {
    CHECK(FilterSampler(PixelFilter::Box, 1.0f).radius_px() == 0.5f);
    CHECK(FilterSampler(PixelFilter::Gaussian, 1.5f).radius_px() == 2.25f);
    CHECK(FilterSampler(PixelFilter::BlackmanHarris, 1.5f).radius_px() == 1.5f);
    // A Gaussian exp(-8 (x / w)^2) has the variance w^2 / 16, less what its ends at 1.5 w cut off: 1e-5.
    CHECK(std::abs(sampled_moment(FilterSampler(PixelFilter::Gaussian, 1.0f), 2) * 16.0 - 1.0) < 1e-3);
}

TEST_CASE("the middle of the unit square is the middle of the pixel, and no sample leaves the filter") {
    for (const PixelFilter kind : all_filters) {
        const FilterSampler filter(kind, 2.0f);
        CHECK(filter.offset_px({0.5f, 0.5f}) == tyndall::vec2(0.0f));
        const float last = std::nextafter(1.0f, 0.0f);
        CHECK(std::abs(filter.offset_px({0.0f, last}).x) <= filter.radius_px());
        CHECK(std::abs(filter.offset_px({0.0f, last}).y) <= filter.radius_px());
    }
}

TEST_CASE("a width that is no width is refused") {
    CHECK_THROWS_AS(FilterSampler(PixelFilter::Box, 0.0f), tyndall::InvalidInput);
    CHECK_THROWS_AS(FilterSampler(PixelFilter::Gaussian, std::numeric_limits<float>::quiet_NaN()),
                    tyndall::InvalidInput);
}
} // namespace pixel_filter_test
