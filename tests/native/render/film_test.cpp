// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/film.hpp"
#include <array>
#include <cmath>
#include <doctest/doctest.h>
#include <limits>

namespace film_test {
using namespace tyndall;
using namespace tyndall::render;

// Seen to fail with all that samples bring added up.
TEST_CASE("a sample that is no number, infinite, or beyond measure leaves its pixel the others' light") {
    constexpr float nan = std::numeric_limits<float>::quiet_NaN(), infinite = std::numeric_limits<float>::infinity(),
                    most = std::numeric_limits<float>::max();
    FilmSums sums(2, 1, {}, dvec3(0.0));
    for (const Rgb& radiance : {Rgb(1.0f, 2.0f, 3.0f), Rgb(nan, infinite, most), Rgb(5.0f, most, 0.0f), Rgb(2.0f)}) {
        PathSample sample;
        sample.radiance = radiance;
        for (const std::size_t pixel : {0u, 1u})
            sums.add(pixel, sample);
    }
    sums.add_world_light(1, Rgb(nan, 4.0f, -infinite));
    sums.add_shafts(1, Rgb(4.0f, infinite, nan), 1.0f);
    const Film film = sums.resolve(Progress());
    const std::vector<float>& values = film.planes.front().values;
    constexpr std::array expected{8.0f, 4.0f, 5.0f, 4.0f, 12.0f, 8.0f, 5.0f, 4.0f}; // with alpha
    for (std::size_t channel = 0; channel < expected.size(); ++channel)
        CHECK(values[channel] == expected[channel] / 4.0f);
}
} // namespace film_test
