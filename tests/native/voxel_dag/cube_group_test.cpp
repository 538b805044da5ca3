// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/cube_group.hpp"
#include <doctest/doctest.h>
#include <random>
#include <set>

namespace cube_group_test {
using namespace tyndall::voxel_dag;

TEST_CASE("the 48 elements are a group: products are elements, inverses undo, and the first 8 are reflections") {
    std::set<std::array<std::uint8_t, 8>> distinct;
    for (std::uint32_t a = 0; a < cube_element_count; ++a) {
        distinct.insert(cube_group.octant[a]);
        REQUIRE(cube_group.product[a][cube_group.inverse[a]] == 0);
        REQUIRE(cube_group.product[cube_group.inverse[a]][a] == 0);
        for (std::uint32_t b = 0; b < cube_element_count; ++b)
            for (std::uint32_t octant = 0; octant < 8; ++octant)
                REQUIRE(cube_group.octant[cube_group.product[a][b]][octant] ==
                        cube_group.octant[a][cube_group.octant[b][octant]]);
    }
    CHECK(distinct.size() == cube_element_count);
    for (std::uint32_t a = 0; a < reflection_count; ++a)
        for (std::uint32_t octant = 0; octant < 8; ++octant)
            REQUIRE(cube_group.octant[a][octant] == (octant ^ a));
}

TEST_CASE("elements keep neighbours: octants that share a face do so afterwards") {
    for (std::uint32_t element = 0; element < cube_element_count; ++element)
        for (std::uint32_t octant = 0; octant < 8; ++octant)
            for (const std::uint32_t step : {1u, 2u, 4u}) {
                const std::uint32_t apart =
                    cube_group.octant[element][octant] ^ cube_group.octant[element][octant ^ step];
                REQUIRE((apart == 1 || apart == 2 || apart == 4));
            }
}

TEST_CASE("a brick is turned voxel by voxel") {
    std::mt19937_64 random(1);
    for (int run = 0; run < 50; ++run) {
        const std::uint64_t leaf = random() & random();
        for (std::uint32_t element = 0; element < cube_element_count; ++element) {
            std::uint64_t wanted = 0;
            for (std::uint32_t voxel = 0; voxel < 64; ++voxel)
                wanted |= (leaf >> voxel & 1) << turned_voxel(element, voxel);
            REQUIRE(turned_leaf(element, leaf) == wanted);
        }
    }
}
} // namespace cube_group_test
