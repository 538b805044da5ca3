// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/errors.hpp"
#include "voxel_dag/leaf_masks.hpp"
#include <algorithm>
#include <doctest/doctest.h>
#include <random>
#include <set>

namespace leaf_masks_test {
using namespace tyndall;
using namespace tyndall::voxel_dag;

static Voxel random_voxel(std::mt19937& random, std::uint32_t level) {
    Voxel voxel;
    for (std::uint32_t& at : voxel)
        at = static_cast<std::uint32_t>(random()) >> (32 - level);
    return voxel;
}

TEST_CASE(
    "a Morton code gives its voxel back, takes bits of x, y and z in turns, and orders octants by their z, y, x") {
    std::mt19937 random(1);
    for (int i = 0; i < 10000; ++i) {
        const Voxel voxel = random_voxel(random, 17);
        const std::uint64_t code = morton_code(voxel);
        REQUIRE(voxel_at(code) == voxel);
        for (std::uint32_t bit = 0; bit < 17; ++bit)
            for (std::uint32_t axis = 0; axis < 3; ++axis)
                REQUIRE((code >> (3 * bit + axis) & 1) == (voxel[axis] >> bit & 1));
    }
    for (std::uint32_t octant = 0; octant < 8; ++octant)
        CHECK(morton_code({octant & 1, octant >> 1 & 1, octant >> 2}) == octant);
}

TEST_CASE("bricks hold the voxels they were made of, whatever their order, and none else") {
    std::mt19937 random(2);
    for (const std::uint32_t level : {2u, 3u, 5u, 17u}) {
        CAPTURE(level);
        std::vector<Voxel> voxels;
        for (int i = 0; i < 500; ++i)
            voxels.push_back(random_voxel(random, level));
        const std::set<Voxel> wanted(voxels.begin(), voxels.end());
        const LeafMasks leaves = leaf_masks_of(voxels, level);
        require_usable(leaves);
        CHECK(leaves.voxel_count() == wanted.size());
        for (const Voxel& voxel : voxels)
            REQUIRE(leaves.contains(voxel));
        for (int i = 0; i < 500; ++i) {
            const Voxel voxel = random_voxel(random, level);
            REQUIRE(leaves.contains(voxel) == wanted.contains(voxel));
        }
        std::ranges::shuffle(voxels, random);
        CHECK(leaf_masks_of(voxels, level) == leaves);
    }
    CHECK_FALSE(leaf_masks_of({{0, 0, 0}}, 2).contains({4, 0, 0}));
}

TEST_CASE("bricks that are empty, twice there or outside are refused, and so are voxels beyond the resolution") {
    CHECK_THROWS_WITH_AS(require_usable({.level = 3, .codes = {0}, .masks = {0}}), "voxels: brick 0 is empty",
                         InvalidInput);
    CHECK_THROWS_AS(require_usable({.level = 3, .codes = {1, 1}, .masks = {1, 1}}), InvalidInput);
    CHECK_THROWS_AS(require_usable({.level = 3, .codes = {8}, .masks = {1}}), InvalidInput);
    CHECK_THROWS_AS(require_usable({.level = 3, .codes = {1}, .masks = {}}), InvalidInput);
    CHECK_THROWS_AS(leaf_masks_of({}, 18), InvalidInput);
    CHECK_THROWS_WITH_AS(leaf_masks_of({{1, 8, 2}}, 3), "voxel (1, 8, 2) lies beyond the resolution, 8", InvalidInput);
}
} // namespace leaf_masks_test
