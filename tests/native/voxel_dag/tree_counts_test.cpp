// SPDX-License-Identifier: GPL-3.0-or-later
#include "support/voxel_sets.hpp"
#include "voxel_dag/build_dag.hpp"
#include "voxel_dag/dag_counts.hpp"
#include "voxel_dag/merge_symmetric.hpp"
#include "voxel_dag/pack_dag.hpp"
#include "voxel_dag/tree_counts.hpp"
#include <doctest/doctest.h>
#include <set>

namespace tree_counts_test {
using namespace tyndall;
using namespace tyndall::voxel_dag;
using namespace tyndall::support;

static Dag merged(const LeafMasks& voxels, Symmetry symmetry) {
    const Progress progress;
    const Dag plain = build_dag(voxels, {}, progress);
    return symmetry == Symmetry::None ? plain : merge_symmetric(plain, {.symmetry = symmetry}, progress);
}

/// Cubes of 2^level voxels a side that are not empty, one by one.
static std::uint64_t occupied(const LeafMasks& voxels, std::uint32_t level) {
    std::set<std::uint64_t> cubes;
    for (std::size_t brick = 0; brick < voxels.codes.size(); ++brick)
        for (std::uint64_t bit = 0; bit < 64; ++bit)
            if ((voxels.masks[brick] >> bit & 1) != 0)
                cubes.insert((voxels.codes[brick] << 3 * leaf_level | bit) >> 3 * level);
    return cubes.size();
}

TEST_CASE("the tree has as many nodes as there are cubes that are not empty; distinct nodes are the DAG's") {
    const Progress progress;
    for (const LeafMasks& voxels :
         {random_voxels(6, 0.05, 1), kaleidoscope_voxels(7, 3), sphere_voxels(6, {30, 31, 29}, 25), full_voxels(5),
          sierpinski_voxels(7), LeafMasks{.level = 2, .codes = {0}, .masks = {0x8001}}})
        for (const Symmetry symmetry : {Symmetry::None, Symmetry::Reflections, Symmetry::Cube}) {
            const Dag dag = merged(voxels, symmetry);
            const PackedDag packed = pack_dag(dag, progress);
            const std::vector<TreeCounts> counts = tree_counts(packed, progress);
            const std::vector<LevelCounts> distinct = level_counts(dag);
            REQUIRE(counts.size() == voxels.level);
            std::uint64_t node_count = 0;
            for (std::uint32_t i = 0; i < counts.size(); ++i) {
                CAPTURE(i);
                CHECK(counts[i].level == i + 1);
                CHECK(counts[i].tree_count == occupied(voxels, i + 1));
                CHECK(counts[i].node_count == (i == 0 ? 0 : distinct[i - 1].node_count));
                node_count += counts[i].node_count;
            }
            CHECK(node_count == packed.node_count);
        }
}

TEST_CASE("an empty DAG has no nodes, and its parts add up to its bytes, too") {
    const Progress progress;
    for (const LeafMasks& voxels : {LeafMasks{.level = 9, .codes = {}, .masks = {}}, random_voxels(6, 0.05, 1)}) {
        const PackedDag packed = pack_dag(merged(voxels, Symmetry::Cube), progress);
        CHECK(tree_counts(packed, progress).empty() == voxels.codes.empty());
        std::uint64_t sum = 0;
        for (const PartBytes& part : bytes_by_part(packed))
            sum += part.byte_count;
        CHECK(sum == packed.byte_count());
    }
}
} // namespace tree_counts_test
