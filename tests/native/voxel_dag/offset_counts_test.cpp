// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/errors.hpp"
#include "support/voxel_sets.hpp"
#include "voxel_dag/build_dag.hpp"
#include "voxel_dag/merge_symmetric.hpp"
#include "voxel_dag/offset_counts.hpp"
#include <doctest/doctest.h>

namespace offset_counts_test {
using namespace tyndall;
using namespace tyndall::voxel_dag;
using namespace tyndall::support;

// The tree below a node of Sierpinski's tetrahedron has 5, 21, 85, 341 and 1365 nodes; the fourth child lies three of these
// and one further: 16, 64, 256, 1024, 4096. Seen to fail with offsets that leave the node itself out.
TEST_CASE("steps of the published layout, by hand, on Sierpinski's tetrahedron: 5 nodes of 4 references, and a mask") {
    const Dag dag = build_dag(sierpinski_voxels(6), {}, Progress());
    CHECK(offset_dag_bytes(dag, {.has_offsets = false}) == 4 + 5 * (4 + 4 * 4));
    CHECK(offset_dag_bytes(dag, {}) == 4 + 5 * (4 + 4 * 8));
    CHECK(offset_dag_bytes(dag, {.has_implicit_first = true}) == 4 + 5 * (4 + 4 * 4 + 3 * 4));
    CHECK(offset_dag_bytes(dag, {.has_offset_bytes = true}) == 4 + 5 * (4 + 4 * 4) + 4 * (1 + 1 + 2 + 2 + 2));
    CHECK(offset_dag_bytes(dag, {.has_pointer_bytes = true}) == 4 + 5 * (4 + 4 * 1 + 4 * 4));
    CHECK(offset_dag_bytes(dag, {.has_byte_masks = true}) == 1 + 5 * (1 + 4 * 8));
    CHECK(offset_dag_bytes(dag, {.has_pointers_by_use = true}) == 4 + 5 * (4 + (4 * 1 + 4) + 4 * 4));
    CHECK(offset_dag_bytes(dag, OffsetLayout::combined()) == 1 + 5 * (1 + 4 * 1 + 4) + 3 * (1 + 1 + 2 + 2 + 2));
    CHECK(offset_dag_bytes(build_dag({.level = 9, .codes = {}, .masks = {}}, {}, Progress()), {}) == 0);
}

TEST_CASE("pointers by use: the first 64 in a byte, the next in two, and in the table where that is worth its entry") {
    // 5,000 leaves that 15 references name, 1,000 that 2 do.
    LeafMasks voxels{.level = 8, .codes = {}, .masks = {}};
    for (std::uint64_t node = 0; node < 10000; ++node)
        for (std::uint64_t octant = 0; octant < (node < 5000 ? 8 : 7); ++octant) {
            voxels.codes.push_back(node << 3 | octant);
            voxels.masks.push_back(node % 5000 + 1);
        }
    for (std::uint64_t leaf = 0; leaf < 1000; ++leaf)
        for (std::uint64_t octant = 0; octant < 2; ++octant) {
            voxels.codes.push_back((10000 + leaf) << 3 | octant);
            voxels.masks.push_back(leaf + 5001);
        }
    Dag dag = build_dag(voxels, {}, Progress());
    dag.levels.resize(1);
    Dag leaves = dag;
    leaves.levels.clear();
    REQUIRE(dag.leaves.size() == 6000);
    const OffsetLayout by_use{.has_offsets = false, .has_pointers_by_use = true};
    const std::uint64_t of_nodes = offset_dag_bytes(dag, by_use) - offset_dag_bytes(leaves, by_use);
    CHECK(of_nodes == 4 * 11000 + 64 * (15 + 4) + 4936 * (15 * 2 + 4) + 1000 * (2 * 4)); // 2 * 2 + 4 is no less
}

TEST_CASE("offsets that tags would turn are refused") {
    const Dag dag = merge_symmetric(build_dag(sierpinski_voxels(6), {}, Progress()), {}, Progress());
    CHECK_THROWS_AS((void)offset_dag_bytes(dag, {}), InvalidInput);
}
} // namespace offset_counts_test
