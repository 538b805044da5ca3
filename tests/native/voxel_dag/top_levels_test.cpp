// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/errors.hpp"
#include "support/packed_voxels.hpp"
#include "support/random_attributes.hpp"
#include "support/voxel_sets.hpp"
#include "voxel_dag/coarse_cubes.hpp"
#include "voxel_dag/dag_file.hpp"
#include "voxel_dag/encode_attributes.hpp"
#include <doctest/doctest.h>
#include <filesystem>
#include <fstream>
#include <unistd.h>

namespace top_levels_test {
using namespace tyndall;
using namespace tyndall::voxel_dag;
using namespace tyndall::support;

static const Progress progress;

static std::vector<std::uint64_t> codes_of(const LeafMasks& voxels) {
    std::vector<std::uint64_t> codes;
    for (const Voxel& voxel : listed(voxels))
        codes.push_back(morton_code(voxel));
    return codes;
}

TEST_CASE("topmost levels are the cubes that have voxels, level by level, as far as bytes allow") {
    for (const LeafMasks& voxels :
         {sphere_voxels(8, {99.3, 126, 120}, 90), random_voxels(6, 0.001, 2), kaleidoscope_voxels(6, 4)}) {
        const PackedDag dag = packed(voxels, Symmetry::Cube);
        const std::vector<TopLevel> all = top_levels_of(dag, {}, {}, progress);
        REQUIRE(all.size() == voxels.level);
        CHECK(voxels_of(all) == voxels);
        for (std::uint32_t level = leaf_level; level <= voxels.level; ++level)
            CHECK(codes_of(voxels_of(std::span(all).first(level))) ==
                  coarse_cubes(dag, level, ~std::size_t{0}, progress).codes);
        const std::uint64_t two = all[0].child_masks.size() + all[1].child_masks.size();
        CHECK(top_levels_of(dag, {}, {.most_bytes = two}, progress).size() == 2);
        CHECK(top_levels_of(dag, {}, {.most_bytes = two - 1}, progress).size() == 1);
        CHECK(top_levels_of(dag, {}, {.most_level = 4}, progress).size() == 4);
    }
    CHECK(top_levels_of({}, {}, {}, progress).empty());
}

TEST_CASE("levels that do not belong together are refused") {
    const PackedDag dag = packed(sphere_voxels(6, {33, 30, 29}, 25), Symmetry::Cube);
    std::vector<TopLevel> levels = top_levels_of(dag, {}, {}, progress);
    levels[3].child_masks.pop_back();
    CHECK_THROWS_AS(static_cast<void>(voxels_of(levels)), InvalidInput);
}

TEST_CASE("a file's topmost levels and their mean colours are read without the rest, which may be damaged") {
    const std::filesystem::path path =
        std::filesystem::temp_directory_path() / ("tyndall_top_test_" + std::to_string(getpid()) + ".tdag");
    PlacedDag placed{.dag = packed(sphere_voxels(9, {250, 260, 240}, 199), Symmetry::Cube),
                     .bounds_m = {.lower_m = dvec3(1, 2, 3), .side_m = 4}};
    placed.attributes = encode_attributes(placed.dag, random_attributes(placed.dag.voxel_count, 3), {}, progress);
    write_dag(placed, path, progress);
    {
        std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
        file.seekp(-200, std::ios::end);
        file << "damaged";
    }
    CHECK_THROWS_AS(static_cast<void>(read_dag(path, progress)), IoError);
    const std::optional<TopOfDag> top = read_top(path, 4, progress);
    REQUIRE(top);
    CHECK(top->bounds_m.lower_m == dvec3(1, 2, 3));
    CHECK(top->bounds_m.side_m == 4.0);
    REQUIRE(top->levels.size() == 4);
    const std::vector<std::uint64_t> codes = codes_of(voxels_of(top->levels));
    CHECK(codes == coarse_cubes(placed.dag, 4, ~std::size_t{0}, progress).codes);
    std::vector<Voxel> lowest;
    for (const std::uint64_t code : codes)
        lowest.push_back(voxel_at(code << 3 * 5));
    CHECK(top->levels[3].colors == colors_at(placed.dag, *placed.attributes, lowest, 5, progress));
    CHECK_FALSE(read_top(path, 9, progress));
    std::filesystem::remove(path);
}
} // namespace top_levels_test
