// SPDX-License-Identifier: GPL-3.0-or-later
// What voxelized surfaces are: closed forms, the same bytes however they are made, and errors that name the culprit.
#include "core/parallel.hpp"
#include "core/simd.hpp"
#include "native/voxel_dag/step_meshes.hpp"
#include <cmath>
#include <doctest/doctest.h>

namespace voxelize_test {
using namespace tyndall;
using namespace tyndall::voxel_dag;
using namespace tyndall::voxel_dag::oracle;
using enum VoxelizeRule;

/// Two triangles over the whole cube of 2^level voxels: corner, corner + a, corner + a + b, corner + b, in voxels.
static std::vector<Triangle> quad(Point corner, Point a, Point b) {
    std::array<Point, 4> corners;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        corners[0][axis] = corner[axis] * 256;
        corners[1][axis] = (corner[axis] + a[axis]) * 256;
        corners[2][axis] = (corner[axis] + a[axis] + b[axis]) * 256;
        corners[3][axis] = (corner[axis] + b[axis]) * 256;
    }
    return {{corners[0], corners[1], corners[2]}, {corners[0], corners[2], corners[3]}};
}

static std::vector<Triangle> random_soup(int seed, std::uint32_t level, int count) {
    std::mt19937 random(static_cast<unsigned>(seed));
    std::vector<Triangle> triangles;
    for (int i = 0; i < count; ++i)
        triangles.push_back(random_triangle(random, level, i % 50 == 0 ? 200 : 6, 2, i % 3 == 0 ? 128 : 1));
    return triangles;
}

TEST_CASE("a plane between two layers of voxels belongs to the upper one, by both rules") {
    for (const VoxelizeRule rule : {Thin, Conservative})
        for (const std::int64_t height : {0, 1, 31, 63, 64, 100, 127}) {
            const VoxelizeResult floor = voxelized(quad({-5, -5, height}, {140, 0, 0}, {0, 140, 0}), 7, rule);
            CHECK(floor.statistics.voxel_count == 128 * 128);
            for (const std::uint32_t at : {0u, 63u, 64u, 127u}) {
                CHECK(floor.leaves.contains({at, 127 - at, static_cast<std::uint32_t>(height)}));
                const VoxelizeResult wall = voxelized(quad({height, -5, -5}, {0, 140, 0}, {0, 0, 140}), 7, rule);
                CHECK(wall.leaves.contains({static_cast<std::uint32_t>(height), at, 127 - at}));
            }
        }
}

TEST_CASE("a diagonal plane through corners of voxels has one voxel in each column, and just one") {
    // x = y: the voxels (i, i, z). x + y = 128, which passes through edges as well: by the tie rule as x + y + e > 128.
    CHECK(voxelized(quad({-5, -5, -5}, {140, 140, 0}, {0, 0, 140}), 7, Thin).statistics.voxel_count == 128 * 128);
    CHECK(voxelized(quad({-5, 133, -5}, {140, -140, 0}, {0, 0, 140}), 7, Thin).statistics.voxel_count == 128 * 128);
    // x - y = 1/2, half a voxel beside the centres on either side: the voxels (y + 1, y, z) have it.
    std::vector<Triangle> between = quad({-5, -5, -5}, {140, 140, 0}, {0, 0, 140});
    for (Triangle& triangle : between)
        for (Point& corner : triangle)
            corner[0] += 128;
    const LeafMasks leaves = voxelized(between, 7, Thin).leaves;
    CHECK(leaves.voxel_count() == 127 * 128);
    CHECK(leaves.contains({64, 63, 127}));
}

TEST_CASE("bounds are the longest side of the box around the triangles, upper faces and all") {
    // A box of 8 x 4 x 2, with a vertex far away that no triangle uses.
    Mesh mesh = mesh_of(box({0, 0, 0}, {8 * 256, 4 * 256, 2 * 256}));
    for (dvec3& position : mesh.positions)
        position = 0.25 * position + dvec3(10, -3, 7);
    mesh.positions.emplace_back(1e6, 0, 0);
    const VoxelizeResult result =
        voxelize(std::span<const dvec3>(mesh.positions), mesh.triangles, {.resolution = 64, .rule = Thin}, Progress());
    // Sides at 0 and 64 along x, where the upper one belongs to voxel 63; at 0 and 32; and at 0 and 16.
    const std::uint64_t around = 64 * 33 * 17, within = 62 * 31 * 15;
    CHECK(result.statistics.voxel_count == around - within);
    CHECK(result.leaves.contains({63, 32, 16}));
    CHECK_FALSE(result.leaves.contains({62, 31, 15}));
}

TEST_CASE("floats voxelize as the doubles of the same value do") {
    std::mt19937 random(7);
    std::vector<vec3> narrow;
    std::vector<uvec3> triangles;
    for (std::uint32_t i = 0; i < 300; ++i) {
        narrow.emplace_back(random() % 9973, random() % 9973, random() % 9973);
        triangles.emplace_back(i, (i + 1) % 300, (i + 7) % 300);
    }
    const std::vector<dvec3> wide(narrow.begin(), narrow.end());
    const VoxelizeConfig config{.resolution = 128};
    CHECK(voxelize(std::span<const vec3>(narrow), triangles, config, Progress()).leaves ==
          voxelize(std::span<const dvec3>(wide), triangles, config, Progress()).leaves);
}

// Seen to fail with a last row that is left out at each tile's upper end.
TEST_CASE("a mesh moved by whole voxels sets the same voxels, moved: tiles leave no trace") {
    std::mt19937 random(8);
    std::vector<Triangle> triangles;
    for (int i = 0; i < 300; ++i)
        triangles.push_back(random_triangle(random, 6, i % 10 == 0 ? 30 : 4, 0, i % 2 == 0 ? 128 : 1));
    const Voxel by{37, 101, 62}; // in a cube of 256 voxels with 64 of margin: nothing is cut off
    std::array<std::vector<Voxel>, 2> sets;
    for (std::uint32_t is_moved = 0; is_moved < 2; ++is_moved) {
        std::vector<Triangle> placed = triangles;
        for (Triangle& triangle : placed)
            for (Point& corner : triangle)
                for (std::size_t axis = 0; axis < 3; ++axis)
                    corner[axis] += 256 * (48 + is_moved * by[axis]);
        const LeafMasks leaves = voxelized(placed, 8, Thin).leaves;
        for (std::size_t brick = 0; brick < leaves.codes.size(); ++brick)
            for (std::uint64_t bit = 0; bit < 64; ++bit)
                if ((leaves.masks[brick] >> bit & 1) != 0) {
                    Voxel voxel = voxel_at(leaves.codes[brick] << 6 | bit);
                    for (std::size_t axis = 0; axis < 3; ++axis)
                        voxel[axis] -= is_moved * by[axis];
                    sets[is_moved].push_back(voxel);
                }
    }
    for (auto& set : sets)
        std::ranges::sort(set);
    CHECK(sets[0].size() > 10000);
    CHECK(sets[0] == sets[1]);
}

TEST_CASE("neither threads, nor vectors, nor the order of triangles or corners change a bit") {
    for (const VoxelizeRule rule : {Thin, Conservative}) {
        const std::vector<Triangle> triangles = random_soup(9, 9, 9000);
        const LeafMasks leaves = voxelized(triangles, 9, rule).leaves;
        CHECK(leaves.voxel_count() > 500000);
        for (const int threads : {1, 2, 7})
            CHECK(with_threads(threads, [&] { return voxelized(triangles, 9, rule).leaves; }) == leaves);
        for (const SimdTarget target : available_simd_targets()) {
            const ForcedSimdTarget forced(target);
            CAPTURE(simd_target_name());
            CHECK(voxelized(triangles, 9, rule).leaves == leaves);
        }
        std::vector<Triangle> shuffled = triangles;
        std::ranges::reverse(shuffled);
        for (std::size_t i = 0; i < shuffled.size(); ++i) {
            std::ranges::rotate(shuffled[i], shuffled[i].begin() + static_cast<std::ptrdiff_t>(i % 3));
            if (i % 2 == 0)
                std::swap(shuffled[i][0], shuffled[i][1]);
        }
        CHECK(voxelized(shuffled, 9, rule).leaves == leaves);
    }
}

TEST_CASE("the thin voxels are among the conservative ones, and each triangle's corners lie in the latter") {
    const std::vector<Triangle> triangles = random_soup(10, 7, 400);
    const LeafMasks thin = voxelized(triangles, 7, Thin).leaves, all = voxelized(triangles, 7, Conservative).leaves;
    for (std::size_t brick = 0; brick < thin.codes.size(); ++brick)
        for (std::uint64_t bit = 0; bit < 64; ++bit)
            if ((thin.masks[brick] >> bit & 1) != 0)
                REQUIRE(all.contains(voxel_at(thin.codes[brick] << 6 | bit)));
    CHECK(thin.voxel_count() < all.voxel_count());
    for (const Triangle& triangle : triangles)
        for (const Point& corner : triangle)
            if (std::ranges::all_of(corner, [](std::int64_t at) { return 0 <= at && at < 128 * 256; }))
                REQUIRE(all.contains({static_cast<std::uint32_t>(corner[0] / 256),
                                      static_cast<std::uint32_t>(corner[1] / 256),
                                      static_cast<std::uint32_t>(corner[2] / 256)}));
}

TEST_CASE("what cannot be voxelized is refused, and the culprit named") {
    std::vector<vec3> positions{vec3(0, 0, 0), vec3(1, 0, 0), vec3(0, 1, 0)};
    std::vector<uvec3> triangles{uvec3(0, 1, 2)};
    const auto run = [&](const VoxelizeConfig& config) {
        return voxelize(std::span<const vec3>(positions), triangles, config, Progress());
    };
    CHECK_THROWS_WITH_AS(run({.resolution = 1000}), "resolution is 1000; powers of two from 4 to 131072 are possible",
                         InvalidInput);
    CHECK_THROWS_AS(run({.resolution = 0}), InvalidInput);
    CHECK_THROWS_AS(run({.resolution = 2}), InvalidInput);
    CHECK_THROWS_AS(run({.resolution = 1u << 31}), InvalidInput);
    CHECK_THROWS_AS(run({.bounds_m = Cube{.lower_m = dvec3(0), .side_m = 0}}), InvalidInput);
    CHECK_THROWS_AS(run({.bounds_m = Cube{.lower_m = dvec3(0), .side_m = NAN}}), InvalidInput);
    CHECK_THROWS_AS(run({.bounds_m = Cube{.lower_m = dvec3(0, NAN, 0), .side_m = 1}}), InvalidInput);
    CHECK_THROWS_AS(run({.bounds_m = Cube{.lower_m = dvec3(0), .side_m = 1e-320}}), InvalidInput);
    CHECK_THROWS_WITH_AS(run({.bounds_m = Cube{.lower_m = dvec3(0), .side_m = 1e-9}}),
                         "vertex 1 at (1, 0, 0) m lies 2^32 voxels or more from the cube of 1e-09 m at (0, 0, 0) m",
                         InvalidInput);
    triangles.emplace_back(0, 3, 1);
    CHECK_THROWS_WITH_AS(run({}), "triangle 1 has the vertices 0, 3, 1; there are 3", InvalidInput);
    triangles.pop_back();
    positions[2].z = NAN;
    CHECK_THROWS_WITH_AS(run({}), "vertex 2 lies at (0, 1, nan) m", InvalidInput);
    positions[2].z = INFINITY;
    CHECK_THROWS_AS(run({}), InvalidInput);
    positions.assign(3, vec3(4));
    CHECK_THROWS_WITH_AS(run({}), "all triangles lie in one point: bounds_m has to say which cube is meant",
                         InvalidInput);
    CHECK(run({.resolution = 8, .bounds_m = Cube{.lower_m = dvec3(0), .side_m = 8}}).leaves.contains({4, 4, 4}));
    CHECK(
        run({.resolution = 8, .bounds_m = Cube{.lower_m = dvec3(5), .side_m = 8}}).statistics.outside_triangle_count ==
        1);
    triangles.clear();
    CHECK_THROWS_WITH_AS(run({}), "the mesh has no triangles", InvalidInput);
}

TEST_CASE("a call that was cancelled throws") {
    Progress progress;
    progress.cancel();
    const Mesh mesh = mesh_of(random_soup(11, 7, 10));
    CHECK_THROWS_AS(voxelize(std::span<const dvec3>(mesh.positions), mesh.triangles, {}, progress), Cancelled);
}
} // namespace voxelize_test
