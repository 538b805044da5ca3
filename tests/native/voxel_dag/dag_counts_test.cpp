// SPDX-License-Identifier: GPL-3.0-or-later
#include "support/voxel_sets.hpp"
#include "voxel_dag/build_dag.hpp"
#include "voxel_dag/dag_counts.hpp"
#include <doctest/doctest.h>

namespace dag_counts_test {
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
    CHECK(level_counts(build_dag({.level = 9, .codes = {}, .masks = {}}, {}, progress)).empty());
}
} // namespace dag_counts_test
