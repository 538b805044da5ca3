// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/listed_voxels.hpp"
#include "voxel_dag/octahedral_normals.hpp"
#include <doctest/doctest.h>
#include <map>
#include <random>

namespace listed_voxels_test {
using namespace tyndall;
using namespace tyndall::voxel_dag;

TEST_CASE("a voxel has what its last row says, in Morton order, however rows are mixed") {
    std::mt19937 random(1);
    std::vector<Voxel> voxels;
    std::vector<ByteColor> colors;
    std::vector<vec3> normals;
    std::vector<std::uint8_t> values;
    std::map<std::uint64_t, std::size_t> last_row;
    for (std::size_t row = 0; row < 5000; ++row) {
        const auto number = static_cast<std::uint32_t>(random());
        voxels.push_back({number & 15, number >> 4 & 15, number >> 8 & 15});
        colors.push_back({static_cast<std::uint8_t>(row), static_cast<std::uint8_t>(row >> 8), 200});
        normals.emplace_back(1.0f, static_cast<float>(row), -2.0f);
        values.push_back(static_cast<std::uint8_t>(3 * row));
        last_row[morton_code(voxels.back())] = row;
    }
    const ListedVoxels listed =
        voxels_of_list(voxels, {.colors = colors, .normals = normals, .channels = {{"wet", values}}}, 4, {});
    CHECK(listed.leaves == leaf_masks_of(voxels, 4));
    VoxelAttributes wanted{.colors = {}, .normals = {}, .channels = {{"wet", {}}}};
    for (const auto& [code, row] : last_row) {
        wanted.colors.push_back(static_cast<std::uint32_t>(row | 200 << 16));
        wanted.normals.push_back(octahedral::encode(dvec3(normals[row]), 32));
        wanted.channels[0].values.push_back(values[row]);
    }
    CHECK(listed.attributes == wanted);
    CHECK(voxels_of_list(voxels, {}, 4, {}).attributes.is_empty());
}

TEST_CASE("a normal without a direction, and arrays of another length, are named") {
    const std::vector<Voxel> voxels(3, Voxel{1, 2, 3});
    const std::vector<vec3> normals{{1, 0, 0}, {0, 0, 0}, {0, 1, 0}};
    CHECK_THROWS_WITH_AS(
        static_cast<void>(voxels_of_list(voxels, {.colors = {}, .normals = normals, .channels = {}}, 4, {})),
        "normal 1 is (0, 0, 0), which is no direction", InvalidInput);
    const std::vector<ByteColor> colors(2);
    CHECK_THROWS_WITH_AS(
        static_cast<void>(voxels_of_list(voxels, {.colors = colors, .normals = {}, .channels = {}}, 4, {})),
        "voxels: 2 colors for 3 voxels", InvalidInput);
}
} // namespace listed_voxels_test
