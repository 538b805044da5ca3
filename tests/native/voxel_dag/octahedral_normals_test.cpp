// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/errors.hpp"
#include "native/voxel_dag/attribute_sequences.hpp"
#include "voxel_dag/octahedral_normals.hpp"
#include <algorithm>
#include <doctest/doctest.h>
#include <numbers>

namespace octahedral_normals_test {
using namespace tyndall;
using namespace tyndall::voxel_dag;

/// By the chord, because a cosine near 1 does not tell small angles apart.
static double degrees_between(const dvec3& a, const dvec3& b) {
    return 2.0 * std::asin(0.5 * glm::length(a - b)) * 180.0 / std::numbers::pi;
}
static double error_of(const dvec3& direction, std::uint32_t bits) {
    return degrees_between(octahedral::decode(octahedral::encode(direction, bits), bits), glm::normalize(direction));
}

// Seen to fail with codes rounded per coordinate instead of the best of four.
TEST_CASE("no direction is further from what is decoded than its bits allow, and brute force comes close to that") {
    test::Random random(1);
    const auto unit = [&] { return random() / 4294967296.0; };
    for (std::uint32_t bits = octahedral::least_bits; bits <= octahedral::most_bits; ++bits) {
        CAPTURE(bits);
        const double bound = octahedral::most_error_degrees(bits);
        double most = 0.0;
        // The whole octahedron, in steps of a 16th of a cell where that is little, and then the middle of each face,
        // where cells are seen largest, at random.
        const int side = bits <= 12 ? 16 << (bits + 1) / 2 : 300;
        for (int y = 0; y <= side; ++y)
            for (int x = 0; x <= side; ++x) {
                const double u = 2.0 * x / side - 1.0, v = 2.0 * y / side - 1.0, z = 1.0 - std::abs(u) - std::abs(v);
                const dvec3 direction = z >= 0.0 ? dvec3(u, v, z)
                                                 : dvec3((1.0 - std::abs(v)) * (u < 0.0 ? -1.0 : 1.0),
                                                         (1.0 - std::abs(u)) * (v < 0.0 ? -1.0 : 1.0), z);
                most = std::max(most, error_of(direction, bits));
            }
        const double cell = 4.0 / static_cast<double>(1u << bits / 2);
        for (int i = 0; i < 20000; ++i) {
            const auto sign = [&] { return random() % 2 == 0 ? 1.0 : -1.0; };
            const dvec3 middle{sign(), sign(), sign()};
            most = std::max(most, error_of(middle + cell * dvec3(unit() - 0.5, unit() - 0.5, unit() - 0.5), bits));
        }
        CHECK(most <= bound * (1.0 + 1e-6));
        CHECK(most >= 0.9 * bound);
    }
    CHECK(octahedral::most_error_degrees(12) < 2.62);
    CHECK(octahedral::most_error_degrees(32) < 0.0025);
}

TEST_CASE("the six axes are exact at any number of bits: a wall's normal stays the wall's") {
    for (std::uint32_t bits = octahedral::least_bits; bits <= octahedral::most_bits; ++bits)
        for (int axis = 0; axis < 3; ++axis)
            for (const double sign : {-1.0, 1.0}) {
                dvec3 direction(0.0);
                direction[axis] = sign;
                CHECK(octahedral::decode(octahedral::encode(direction, bits), bits) == direction);
            }
}

TEST_CASE("every code is a direction, and what was decoded is decoded again") {
    for (const std::uint32_t bits : {8u, 9u, 12u, 13u})
        for (std::uint32_t code = 0; code < 1u << bits; ++code) {
            const dvec3 direction = octahedral::decode(code, bits);
            REQUIRE(std::abs(glm::length(direction) - 1.0) < 1e-12);
            REQUIRE(degrees_between(octahedral::decode(octahedral::encode(direction, bits), bits), direction) < 1e-6);
        }
}

TEST_CASE("the length of a normal does not matter, tiny or huge, and one without a direction is named") {
    const std::vector<vec3> lengths{{1, 2, 3}, {1e-20f, 2e-20f, 3e-20f}, {1e18f, 2e18f, 3e18f}};
    const auto codes = octahedral::encode_all(lengths, 16, {});
    CHECK(codes[1] == codes[0]);
    CHECK(codes[2] == codes[0]);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    CHECK_THROWS_WITH_AS(octahedral::encode_all(std::vector<vec3>{{1, 0, 0}, {0, 0, 0}}, 12, {}),
                         "normal 1 is (0, 0, 0), which is no direction", InvalidInput);
    CHECK_THROWS_AS(octahedral::encode_all(std::vector<vec3>{{1, nan, 0}}, 12, {}), InvalidInput);
    CHECK_THROWS_WITH_AS(octahedral::encode_all({}, 7, {}), "normals of 7 bits; from 8 to 32 are possible",
                         InvalidInput);
}

TEST_CASE("rounded coordinates are up to 1.5 times as far off as the best, and the axes are exact") {
    test::Random random(5);
    const auto one = [&] { return static_cast<double>(random()) - 2147483647.5; };
    double most = 0;
    for (int i = 0; i < 200000; ++i) {
        const dvec3 direction(one(), one(), one());
        const dvec3 decoded = octahedral::decode(octahedral::encode_rounded(direction), octahedral::most_bits);
        most = std::max(most, degrees_between(decoded, glm::normalize(direction)));
    }
    CHECK(most < 1.5 * octahedral::most_error_degrees(octahedral::most_bits));
    CHECK(most > 0.75 * octahedral::most_error_degrees(octahedral::most_bits));
    for (int axis = 0; axis < 3; ++axis)
        for (const double way : {-1.0, 1.0}) {
            dvec3 direction(0);
            direction[axis] = way;
            CHECK(octahedral::decode(octahedral::encode_rounded(direction), octahedral::most_bits) == direction);
        }
}
} // namespace octahedral_normals_test
