// SPDX-License-Identifier: GPL-3.0-or-later
// voxelize() against the oracle, which looks at each voxel on its own.
#include "native/voxel_dag/step_meshes.hpp"
#include <doctest/doctest.h>

namespace voxelize_oracle_test {
using namespace tyndall;
using namespace tyndall::voxel_dag;
using namespace tyndall::voxel_dag::oracle;

static void check_against_oracle(const std::vector<Triangle>& triangles, std::uint32_t level) {
    for (const VoxelizeRule rule : {VoxelizeRule::Thin, VoxelizeRule::Conservative}) {
        const bool is_thin = rule == VoxelizeRule::Thin;
        CAPTURE(is_thin);
        const VoxelizeResult result = voxelized(triangles, level, rule);
        const LeafMasks truth = voxels_of(triangles, level, rule);
        CHECK_NOTHROW(require_usable(result.leaves));
        CHECK(result.leaves.voxel_count() == truth.voxel_count());
        CHECK(result.statistics.voxel_count == truth.voxel_count());
        CHECK(result.leaves == truth);
    }
}

// Seen to fail with a tie that counts on either side, with 0.5 left out of the lines' offsets, and with rows and depths
// exchanged in the place of a word.
TEST_CASE("triangles set the voxels that no plane and no edge parts them from, and no others") {
    std::mt19937 random(3);
    struct Kind {
        std::uint32_t level;
        std::int64_t reach, grid;
        int count;
    };
    // Corners on multiples of 1/2 voxel meet faces, edges and corners of voxels in most tests; of 1/256, in hardly any.
    for (const Kind& kind :
         {Kind{2, 3, 128, 300}, Kind{3, 6, 128, 300}, Kind{5, 10, 128, 100}, Kind{5, 40, 256, 60}, Kind{6, 5, 1, 200},
          Kind{7, 20, 128, 60}, Kind{7, 30, 1, 60}, Kind{8, 12, 64, 100}, Kind{8, 90, 256, 12}, Kind{8, 200, 1, 6}}) {
        CAPTURE(kind.level);
        CAPTURE(kind.reach);
        CAPTURE(kind.grid);
        for (int i = 0; i < kind.count; ++i)
            check_against_oracle({random_triangle(random, kind.level, kind.reach, kind.reach / 2, kind.grid)},
                                 kind.level);
    }
}

TEST_CASE("many triangles set the union of what each of them sets") {
    std::mt19937 random(4);
    std::vector<Triangle> triangles;
    for (int i = 0; i < 2000; ++i)
        triangles.push_back(random_triangle(random, 8, 4, 0, i % 2 == 0 ? 1 : 128));
    check_against_oracle(triangles, 8);
}

// Seen to fail with a digit of the tiles' order left out, and with blocks of 64^3 tiles that lose their last one.
TEST_CASE("in cubes of thousands of tiles, each triangle finds its own, wherever they lie") {
    std::mt19937 random(13);
    for (const std::uint32_t level : {11u, 13u, 15u, 17u}) {
        CAPTURE(level);
        std::vector<Triangle> triangles;
        for (int place = 0; place < 6; ++place) {
            Point corner;
            for (std::int64_t& at : corner)
                at = random_below(random, (std::int64_t{1} << level) - 300) * 256;
            for (int i = 0; i < 20; ++i) { // neighbours, whose tiles are mixed in the order of triangles
                Triangle triangle = random_triangle(random, 8, 12, 0, i % 2 == 0 ? 1 : 128);
                for (Point& at : triangle)
                    for (std::size_t axis = 0; axis < 3; ++axis)
                        at[axis] += corner[axis];
                triangles.push_back(triangle);
            }
            if (place >= 3)
                continue;
            // A sliver along each axis, through all tiles from end to end.
            Triangle sliver{corner, corner, corner};
            const auto axis = static_cast<std::size_t>(place);
            sliver[0][axis] = 300;
            sliver[1][axis] = ((std::int64_t{1} << level) - 2) * 256;
            sliver[2][(axis + 1) % 3] += 700;
            sliver[2][(axis + 2) % 3] += 400;
            triangles.push_back(sliver);
        }
        check_against_oracle(triangles, level);
    }
}

TEST_CASE("triangles that are a point or a line set what a triangle as thin as that would") {
    std::mt19937 random(5);
    for (int i = 0; i < 300; ++i) {
        const std::int64_t grid = i % 3 == 0 ? 256 : i % 3 == 1 ? 128 : 1;
        Triangle triangle = random_triangle(random, 5, 12, 2, grid);
        if (i % 2 == 0)
            triangle[2] = triangle[1];
        else // three places on one line
            for (std::size_t axis = 0; axis < 3; ++axis)
                triangle[2][axis] = 3 * triangle[1][axis] - 2 * triangle[0][axis];
        check_against_oracle({triangle}, 5);
        triangle[1] = triangle[2] = triangle[0];
        check_against_oracle({triangle}, 5);
    }
    // Along an axis, and across the diagonals of faces and cubes, from corner to corner.
    for (const Point& along : {Point{1, 0, 0}, Point{0, -1, 0}, Point{1, 1, 0}, Point{1, 0, -1}, Point{-1, 1, 1}}) {
        const Point from{16 * 256, 16 * 256, 16 * 256};
        Point to = from;
        for (std::size_t axis = 0; axis < 3; ++axis)
            to[axis] += 9 * 256 * along[axis];
        check_against_oracle({{from, to, from}}, 5);
    }
}

TEST_CASE("triangles far larger than the cube are as exact as small ones, down to 128 bits") {
    std::mt19937 random(6);
    for (const std::uint32_t level : {3u, 5u, 7u})
        for (const int far_bits : {17, 20, 24, 28, 33, 39}) {
            CAPTURE(level);
            CAPTURE(far_bits);
            for (int i = 0; i < (level == 7 ? 3 : 20); ++i) {
                // A corner anywhere; then a plane through a place in the cube.
                const std::int64_t middle = std::int64_t{128} << level, far = std::int64_t{1} << far_bits;
                Triangle triangle;
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    const std::int64_t a = random_below(random, far) - far / 2, b = random_below(random, far) - far / 2;
                    triangle[0][axis] = middle + a;
                    triangle[1][axis] = middle + b;
                    triangle[2][axis] = middle - a - b + random_below(random, 99);
                }
                check_against_oracle({triangle}, level);
                for (Point& corner : triangle) // a wall, whose long normal has a short name
                    corner[1] = middle;
                check_against_oracle({triangle}, level);
                for (Point& corner : triangle) // and the diagonal through corners
                    corner[0] = 2 * middle - corner[2];
                check_against_oracle({triangle}, level);
            }
        }
}
} // namespace voxelize_oracle_test
