// SPDX-License-Identifier: GPL-3.0-or-later
// Voxels are mirrored, not meshes: a mesh's ties have a side.
#include "support/voxel_sets.hpp"
#include "voxel_dag/build_dag.hpp"
#include "voxel_dag/merge_symmetric.hpp"
#include <doctest/doctest.h>

namespace reflected_dag_test {
using namespace tyndall;
using namespace tyndall::voxel_dag;
using namespace tyndall::support;

namespace {
const Progress progress;

/// Numbers in the order in which they are asked for.
class FirstUse {
public:
    explicit FirstUse(std::size_t count) : numbers_(count, none) {}
    std::uint32_t number_of(std::uint32_t old) {
        if (numbers_[old] == none) {
            numbers_[old] = static_cast<std::uint32_t>(order_.size());
            order_.push_back(old);
        }
        return numbers_[old];
    }
    [[nodiscard]] const std::vector<std::uint32_t>& order() const { return order_; }

private:
    static constexpr std::uint32_t none = ~0u;
    std::vector<std::uint32_t> numbers_, order_;
};

/// A DAG without tags, mirrored: octants change places, bits of leaves do, and nodes are numbered anew from the root.
Dag mirrored(const Dag& dag, std::uint32_t element) {
    Dag image{.level = dag.level, .leaves = {}, .levels = std::vector<DagLevel>(dag.levels.size())};
    std::vector<std::uint32_t> order{0};
    for (std::size_t i = dag.levels.size(); i-- > 0;) {
        const DagLevel& nodes = dag.levels[i];
        DagLevel& turned = image.levels[i];
        FirstUse below(i == 0 ? dag.leaves.size() : dag.levels[i - 1].node_count());
        turned.first_children.push_back(0);
        for (const std::uint32_t node : order) {
            std::uint32_t mask = 0;
            for (std::uint32_t there = 0; there < 8; ++there) {
                const std::uint32_t octant = cube_group.octant[element][there]; // a reflection undoes itself
                if ((nodes.child_masks[node] >> octant & 1) == 0)
                    continue;
                mask |= 1u << there;
                turned.children.push_back(below.number_of(nodes.children[nodes.reference(node, octant)]));
            }
            turned.child_masks.push_back(static_cast<std::uint8_t>(mask));
            turned.first_children.push_back(static_cast<std::uint32_t>(turned.children.size()));
        }
        order = below.order();
    }
    for (const std::uint32_t leaf : order)
        image.leaves.push_back(turned_leaf(element, dag.leaves[leaf]));
    return image;
}

std::vector<std::size_t> node_counts(const Dag& dag) {
    std::vector<std::size_t> counts{dag.leaves.size()};
    for (const DagLevel& nodes : dag.levels)
        counts.push_back(nodes.node_count());
    return counts;
}
} // namespace

TEST_CASE("mirrored voxels have as many nodes on each level, and an equal DAG after renumbering") {
    for (const LeafMasks& voxels : {sphere_voxels(8, {120.3, 128, 133.3}, 100), random_voxels(6, 0.01, 1),
                                    kaleidoscope_voxels(7, 2), random_voxels(2, 0.3, 3), sierpinski_voxels(7)}) {
        const Dag dag = build_dag(voxels, {}, progress);
        for (std::uint32_t element = 1; element < symmetry_order(Symmetry::Reflections); ++element) {
            const Dag other = build_dag(turned_voxels(voxels, element), {}, progress);
            CHECK(node_counts(other) == node_counts(dag));
            CHECK(other == mirrored(dag, element));
            for (const Symmetry symmetry : {Symmetry::Reflections, Symmetry::Cube})
                CHECK(node_counts(merge_symmetric(other, {.symmetry = symmetry}, progress)) ==
                      node_counts(merge_symmetric(dag, {.symmetry = symmetry}, progress)));
        }
    }
}
} // namespace reflected_dag_test
