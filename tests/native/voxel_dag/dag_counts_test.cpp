// SPDX-License-Identifier: GPL-3.0-or-later
#include "support/voxel_sets.hpp"
#include "voxel_dag/build_dag.hpp"
#include "voxel_dag/dag_counts.hpp"
#include <doctest/doctest.h>

using namespace tyndall;
using namespace tyndall::voxel_dag;
using namespace tyndall::support;

TEST_CASE("counts of Sierpinski's tetrahedron: 4 references per node, nothing used once but the root") {
    const Progress progress;
    const Dag dag = build_dag(sierpinski_voxels(6), {}, progress);
    const std::vector<LevelCounts> counts = level_counts(dag);
    REQUIRE(counts.size() == 5);
    for (std::uint32_t i = 0; i < counts.size(); ++i) {
        CHECK(counts[i].level == leaf_level + i);
        CHECK(counts[i].node_count == 1);
        CHECK(counts[i].reference_count == (i == 0 ? 0 : 4));
        CHECK(counts[i].once_count == (i + 1 == counts.size() ? 1 : 0));
    }
    CHECK(half_word_bytes(dag) == 8 + 4 * (2 + 4 * 2)); // all near
    CHECK(word_bytes(dag) == 5 * 4 * (1 + 4));          // that of 4^3 has four children, too
    CHECK(level_counts(build_dag({.level = 9, .codes = {}, .masks = {}}, {}, progress)).empty());
}

// Seen to fail with nodes in the order of their numbers.
TEST_CASE(
    "in the published layout the first 2^13 leaves by use are near, and references to others take twice as much") {
    // One 8^3 for each of 9,000 leaves, which hold it in all octants; those after the first 4,000 come once more, with
    // an empty octant. The 5,000 leaves that are used 15 times come first, then 3,192 of the others: 808 are far.
    LeafMasks voxels{.level = 8, .codes = {}, .masks = {}};
    for (std::uint64_t node = 0; node < 14000; ++node)
        for (std::uint64_t octant = 0; octant < (node < 9000 ? 8 : 7); ++octant) {
            voxels.codes.push_back(node << 3 | octant);
            voxels.masks.push_back((node < 9000 ? node : node - 5000) + 1);
        }
    const Progress progress;
    const Dag dag = build_dag(voxels, {}, progress);
    Dag two_levels = dag;
    two_levels.levels.resize(1);
    REQUIRE(dag.leaves.size() == 9000);
    CHECK(half_word_bytes(two_levels) == 8 * 9000 + 2 * (9000 * 9 + 5000 * 8 + 808 * 8));
}
