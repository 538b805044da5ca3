// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/errors.hpp"
#include "support/packed_voxels.hpp"
#include "support/voxel_sets.hpp"
#include "voxel_dag/coarse_voxels.hpp"
#include <doctest/doctest.h>

namespace coarse_voxels_test {
using namespace tyndall;
using namespace tyndall::voxel_dag;
using namespace tyndall::support;

static const Progress progress;

TEST_CASE("coarse voxels are the cubes that have any, of voxels and of their DAG alike") {
    for (const LeafMasks& leaves : {random_voxels(6, 0.01, 5), sphere_voxels(8, {128, 120, 128}, 100), full_voxels(5),
                                    random_voxels(2, 0.1, 6), LeafMasks{.level = 7, .codes = {}, .masks = {}}}) {
        const PackedDag dag = packed(leaves, Symmetry::Cube);
        CHECK(voxels_of(leaves) == listed(leaves));
        for (std::uint32_t level = 0; level + 2 <= leaves.level; ++level) {
            std::vector<Voxel> wanted;
            for (const Voxel& voxel : listed(leaves))
                wanted.push_back({voxel[0] >> level, voxel[1] >> level, voxel[2] >> level});
            const LeafMasks coarse = leaf_masks_of(wanted, leaves.level - level);
            CHECK(coarse_voxels(leaves, level) == coarse);
            for (const Voxel& lowest : voxels_of(coarse, level))
                REQUIRE(std::ranges::all_of(lowest, [&](std::uint32_t at) { return at >> level << level == at; }));
            CHECK(voxels_of(coarse, level).size() == coarse.voxel_count());
            CHECK(coarse_voxels(dag, level, ~std::uint64_t{0}, progress) == coarse);
        }
    }
    CHECK_THROWS_AS(static_cast<void>(coarse_voxels(full_voxels(5), 4)), InvalidInput);
    CHECK_THROWS_AS(static_cast<void>(coarse_voxels(full_voxels(2), ~0u)), InvalidInput);
}

TEST_CASE("a DAG that is larger than memory is refused while it is unpacked") {
    // 2^51 voxels in a graph of one node per level.
    Dag dag{.level = 17, .leaves = {~std::uint64_t{0}}, .levels = {}};
    for (std::uint32_t level = 3; level <= 17; ++level)
        dag.levels.push_back(
            {.child_masks = {0xff}, .first_children = {0, 8}, .children = std::vector<std::uint32_t>(8), .tags = {}});
    const PackedDag all = pack_dag(dag, progress);
    REQUIRE(all.voxel_count == std::uint64_t{1} << 51);
    CHECK_THROWS_AS(static_cast<void>(coarse_voxels(all, 0, 1 << 24, progress)), InvalidInput);
    Progress cancelled;
    cancelled.cancel();
    CHECK_THROWS_AS(static_cast<void>(coarse_voxels(all, 0, 1 << 24, cancelled)), Cancelled);
}
} // namespace coarse_voxels_test
