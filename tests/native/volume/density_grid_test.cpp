// SPDX-License-Identifier: GPL-3.0-or-later
// A density grid is what interpolation between all of its voxels says, however few of them are stored.
#include "core/errors.hpp"
#include "core/random.hpp"
#include "support/density_grids.hpp"
#include "volume/density_walk.hpp"
#include <doctest/doctest.h>

namespace density_grid_test {
using namespace tyndall;

namespace {
constexpr int size = 24;
float random(std::uint32_t a, std::uint32_t b) { return unit_float(pcg4d({a, b, 7, 3})[0]); }

/// Random voxels, of which nine leaves of ten are empty.
float sparse(int x, int y, int z) {
    if (x < 0 || y < 0 || z < 0 || x >= size || y >= size || z >= size)
        return 0.0f;
    const auto leaf = static_cast<std::uint32_t>((x / 8 * 3 + y / 8) * 3 + z / 8);
    return random(leaf, 99) > 0.4f ? 0.0f : random(static_cast<std::uint32_t>((x * size + y) * size + z), leaf);
}
DensityGrid grid_of(const support::DensityOfVoxel& density) {
    return {support::leaves_of(size, density, glm::dmat4(1.0)), Progress()};
}
/// In index space, from the eight voxels around.
double brute_force(const dvec3& at) {
    const glm::ivec3 cell(glm::floor(at));
    const dvec3 f = at - dvec3(cell);
    double sum = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::ivec3 offset(corner & 1, corner >> 1 & 1, corner >> 2);
        const dvec3 weight = dvec3(offset) * f + (1.0 - dvec3(offset)) * (1.0 - f);
        sum += weight.x * weight.y * weight.z * double{sparse(cell.x + offset.x, cell.y + offset.y, cell.z + offset.z)};
    }
    return sum;
}
dvec3 random_point(std::uint32_t seed, double low, double high) {
    return low + (high - low) * dvec3(random(seed, 1), random(seed, 2), random(seed, 3));
}
dvec3 grid_from_index(const DensityGrid& grid, const dvec3& index) {
    return dvec3(glm::inverse(grid.local_from_grid()) * glm::dvec4(index, 1.0));
}
} // namespace

TEST_CASE("a density between voxels is the trilinear interpolation of all of them, stored or not") {
    const DensityGrid grid = grid_of(sparse);
    CHECK(grid.brick_count() < 64); // of 4^3 that the voxels' cells touch
    for (std::uint32_t seed = 0; seed < 20000; ++seed) {
        const dvec3 at = random_point(seed, -3.0, size + 2.0);
        const double error = grid.at(vec3(grid_from_index(grid, at))).x - brute_force(at);
        REQUIRE(std::abs(error) < 1e-5); // the place is a float
    }
}

TEST_CASE("the integral along a line is that of the interpolated density, and skips nothing that is dense") {
    const DensityGrid grid = grid_of(sparse);
    for (std::uint32_t seed = 0; seed < 200; ++seed) {
        const dvec3 from = random_point(2 * seed, -8.0, size + 8.0), to = random_point(2 * seed + 1, -8.0, size + 8.0);
        const GridLine line{grid_from_index(grid, from), to - from};
        double sum = 0.0;
        constexpr int steps = 40000;
        for (int step = 0; step < steps; ++step)
            sum += brute_force(from + (step + 0.5) / steps * (to - from)) / steps;
        CAPTURE(seed);
        CHECK(std::abs(density_integral(grid, line, 0.0, 1.0).x - sum) < 2e-5 * (sum + 0.1));
    }
}

TEST_CASE("a line that runs along the faces of cells and bricks meets their density once") {
    const DensityGrid grid = grid_of([](int, int, int) { return 2.0f; });
    for (const double y : {0.0, 7.0, 8.0, 8.5, 16.0, 23.0}) {
        const GridLine line{grid_from_index(grid, {-5.0, y, 8.0}), {1, 0, 0}};
        // Full between the outer voxels, and falling to 0 over half a triangle at either end.
        CHECK(std::abs(density_integral(grid, line, 0.0, 100.0).x / (2.0 * size) - 1.0) < 1e-6);
        CHECK(std::abs(density_integral(grid, line, 7.0, 9.5).x / (2.0 * 2.5) - 1.0) < 1e-6);
    }
}

TEST_CASE("the density of a ramp has the closed form of its cubic along any line") {
    const DensityGrid grid = grid_of([](int x, int, int z) { return static_cast<float>(x) * static_cast<float>(z); });
    const dvec3 from(1.3, 2.1, 3.7), to(20.2, 18.8, 21.9);
    const GridLine line{grid_from_index(grid, from), to - from};
    const dvec3 d = to - from; // integral of (x + dx t)(z + dz t)
    const double expected = from.x * from.z + 0.5 * (from.x * d.z + from.z * d.x) + d.x * d.z / 3.0;
    CHECK(std::abs(density_integral(grid, line, 0.0, 1.0).x / expected - 1.0) < 1e-6);
}

// Seen to fail with a channel's values at the place of the one before it.
TEST_CASE("densities of the same voxels read together are those of each alone, wherever each has leaves") {
    const auto of_channel = [](int channel) {
        return [channel](int x, int y, int z) {
            const int shift = 8 * channel; // other leaves of each
            return channel == 2 ? 0.0f : static_cast<float>(channel + 1) * sparse((x + shift) % size, y, z);
        };
    };
    for (const std::size_t count : {2u, 3u, 4u}) {
        std::vector<GridLeaves> leaves;
        for (std::size_t channel = 0; channel < count; ++channel)
            leaves.push_back(support::leaves_of(size, of_channel(static_cast<int>(channel)), glm::dmat4(1.0)));
        const DensityGrid together(leaves, Progress());
        CHECK(together.channel_count() == count);
        for (std::size_t channel = 0; channel < count; ++channel) {
            const int at_channel = static_cast<int>(channel);
            const DensityGrid alone(leaves[channel], Progress());
            for (std::uint32_t seed = 0; seed < 500; ++seed) {
                const dvec3 from = random_point(2 * seed, -3.0, size + 3.0),
                            to = random_point(2 * seed + 1, -3.0, size + 3.0);
                const float density = together.at(vec3(grid_from_index(together, from)))[at_channel];
                const GridLine line{grid_from_index(together, from), to - from};
                const double integral = density_integral(together, line, 0.0, 1.0)[at_channel];
                if (alone.is_empty()) {
                    REQUIRE(density == 0.0f);
                    REQUIRE(integral == 0.0);
                    continue;
                }
                REQUIRE(std::abs(density - alone.at(vec3(grid_from_index(alone, from))).x) < 2e-5f);
                const GridLine own{grid_from_index(alone, from), to - from};
                REQUIRE(std::abs(integral - density_integral(alone, own, 0.0, 1.0).x) < 2e-6 * (integral + 1.0));
            }
        }
    }
}

TEST_CASE("a grid far from its origin of indices is as precise as one at it") {
    GridLeaves leaves = support::leaves_of(size, sparse, glm::dmat4(1.0));
    for (glm::ivec3& origin : leaves.origins)
        origin += 8 * glm::ivec3(100000, -70000, 3);
    const DensityGrid grid(leaves, Progress());
    const dvec3 shift(800000, -560000, 24);
    for (std::uint32_t seed = 0; seed < 1000; ++seed) {
        const dvec3 at = random_point(seed, 0.0, size);
        CHECK(std::abs(grid.at(vec3(grid_from_index(grid, at + shift))).x - brute_force(at)) < 1e-5);
    }
}

TEST_CASE("an empty grid is empty, and a density below 0 counts as none") {
    const DensityGrid nothing(GridLeaves{.name = "nothing"}, Progress());
    CHECK(nothing.is_empty());
    CHECK(nothing.at(vec3(0.0f)) == vec4(0.0f));
    CHECK(density_integral(nothing, {dvec3(0.0), {1, 0, 0}}, 0.0, 10.0).x == 0.0);
    const DensityGrid negative = grid_of([](int x, int, int) { return x == 5 ? -1.0f : 0.0f; });
    CHECK(negative.is_empty());
}

TEST_CASE("densities that are no numbers, leaves that overlap and flat transforms are refused by name") {
    const auto refused = [](auto&& spoil, const char* message) {
        GridLeaves leaves = support::leaves_of(
            8, [](int, int, int) { return 1.0f; }, glm::dmat4(1.0));
        leaves.name = "smoke";
        spoil(leaves);
        CHECK_THROWS_WITH_AS(DensityGrid(leaves, Progress()), message, InvalidInput);
    };
    refused([](GridLeaves& leaves) { leaves.values[3] = std::numeric_limits<float>::quiet_NaN(); },
            "grid \"smoke\": a voxel's density is nan, outside [0, 1e+09]");
    refused([](GridLeaves& leaves) { leaves.values[3] = 1e30f; },
            "grid \"smoke\": a voxel's density is 1e+30, outside [0, 1e+09]");
    std::vector<GridLeaves> channels(5, support::leaves_of(
                                            8, [](int, int, int) { return 1.0f; }, glm::dmat4(1.0)));
    CHECK_THROWS_WITH_AS(DensityGrid(channels, Progress()), "5 grids together; 1 to 4 are possible", InvalidInput);
    channels.resize(2);
    channels[0].name = "smoke", channels[1].name = "heat";
    channels[1].local_from_index[3].x = 1.0;
    CHECK_THROWS_WITH_AS(DensityGrid(channels, Progress()), "grids \"smoke\" and \"heat\" have other voxels",
                         InvalidInput);
    refused([](GridLeaves& leaves) { leaves.values.pop_back(); }, "grid \"smoke\": 1 leaves have 511 values");
    refused([](GridLeaves& leaves) { leaves.origins[0].y = 3; },
            "grid \"smoke\": a leaf begins at voxel 3, which is no multiple of 8");
    refused(
        [](GridLeaves& leaves) {
            leaves.origins.push_back(leaves.origins[0]);
            leaves.values.insert(leaves.values.end(), 512, 1.0f);
        },
        "grid \"smoke\": two leaves begin at the same voxel");
    refused([](GridLeaves& leaves) { leaves.local_from_index[2] = glm::dvec4(0.0); },
            "grid \"smoke\": its transform is not finite or has no inverse");
    refused(
        [](GridLeaves& leaves) {
            leaves.origins.push_back(glm::ivec3(80000000));
            leaves.values.insert(leaves.values.end(), 512, 1.0f);
        },
        "grid \"smoke\": its leaves lie too far apart, over 1e+21 blocks of 8^3 voxels");
}
} // namespace density_grid_test
