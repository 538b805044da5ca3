// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/random.hpp"
#include "core/sobol.hpp"
#include "support/chi_square.hpp"
#include <doctest/doctest.h>
#include <set>

namespace sobol_test {
using namespace tyndall;

// Seen to fail with the index shuffled by hash(index) instead of an Owen scramble.
TEST_CASE("of 2^k points exactly one lies in each of the 2^k boxes of any shape, whatever the seed") {
    for (const std::uint32_t seed : {0u, 1u, 12345u, 0xffffffffu})
        for (std::uint32_t k = 0; k <= 10; ++k)
            for (std::uint32_t a = 0; a <= k; ++a) {
                std::set<std::pair<int, int>> boxes;
                for (std::uint32_t index = 0; index < 1u << k; ++index) {
                    const vec2 point = sobol_point(index, seed);
                    boxes.insert({static_cast<int>(std::ldexp(point.x, static_cast<int>(a))),
                                  static_cast<int>(std::ldexp(point.y, static_cast<int>(k - a)))});
                }
                CAPTURE(seed);
                CAPTURE(k);
                CAPTURE(a);
                CHECK(boxes.size() == 1u << k);
            }
}
TEST_CASE("the first points of different seeds fill the square evenly: pixels do not resemble each other") {
    constexpr std::uint32_t side = 16, count = 50000;
    std::vector<double> observed(side * side), expected(side * side, double{count} / (side * side));
    for (std::uint32_t seed = 0; seed < count; ++seed) {
        const vec2 point = sobol_point(5, hash(seed, 9u));
        observed[static_cast<std::size_t>(point.x * side) * side + static_cast<std::size_t>(point.y * side)] += 1.0;
    }
    CHECK(support::is_plausible(support::chi_square_p_value(observed, expected), 2));
}
TEST_CASE("a smooth integral converges nearly with 1 / count, where random numbers give 1 / sqrt(count)") {
    const auto error = [](std::uint32_t count) {
        double squared = 0.0;
        for (std::uint32_t seed = 0; seed < 64; ++seed) {
            double sum = 0.0;
            for (std::uint32_t index = 0; index < count; ++index) {
                const vec2 p = sobol_point(index, seed);
                sum += std::exp(-double{p.x} - 2.0 * p.y);
            }
            const double exact = (1.0 - std::exp(-1.0)) * (1.0 - std::exp(-2.0)) / 2.0;
            squared += (sum / count - exact) * (sum / count - exact);
        }
        return std::sqrt(squared / 64);
    };
    CHECK(error(4096) < error(64) / 64.0); // random numbers: a factor of 8
}
TEST_CASE("counter-based numbers are uniform in each output, and 1 is never rounded to") {
    constexpr std::uint32_t cells = 256, count = 100000;
    for (std::size_t output = 0; output < 4; ++output) {
        std::vector<double> observed(cells), expected(cells, double{count} / cells);
        for (std::uint32_t index = 0; index < count; ++index)
            observed[pcg4d({index, 0, 0, 1})[output] >> 24] += 1.0;
        CHECK(support::is_plausible(support::chi_square_p_value(observed, expected), 4));
    }
    CHECK(unit_float(0xffffffffu) < 1.0f);
}
TEST_CASE("flipping one bit of a counter flips each bit of its hash in about half of all cases") {
    for (std::uint32_t input_bit = 0; input_bit < 32; ++input_bit)
        for (std::uint32_t output_bit = 0; output_bit < 32; ++output_bit) {
            int flips = 0;
            for (std::uint32_t value = 0; value < 1000; ++value)
                flips += (hash(value * 77u) ^ hash((value * 77u) ^ (1u << input_bit))) >> output_bit & 1u;
            CHECK(std::abs(flips - 500) < 80); // 5 sigma of a fair coin; 1024 pairs are looked at
        }
}
} // namespace sobol_test
