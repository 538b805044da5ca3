// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/dag.hpp"
#include "core/errors.hpp"
#include "voxel_dag/cube_group.hpp"
#include <algorithm>

namespace tyndall::voxel_dag {
std::size_t Dag::node_count() const {
    std::size_t count = leaves.size();
    for (const DagLevel& nodes : levels)
        count += nodes.node_count();
    return count;
}

std::uint64_t Dag::voxel_count() const {
    std::vector<std::uint64_t> below;
    for (const std::uint64_t leaf : leaves)
        below.push_back(static_cast<std::uint64_t>(std::popcount(leaf)));
    for (const DagLevel& nodes : levels) {
        std::vector<std::uint64_t> counts(nodes.node_count(), 0);
        for (std::size_t node = 0; node < counts.size(); ++node)
            for (std::uint32_t i = nodes.first_children[node]; i < nodes.first_children[node + 1]; ++i)
                counts[node] += below[nodes.children[i]];
        below = std::move(counts);
    }
    return below.empty() ? 0 : below.front();
}

bool Dag::contains(const Voxel& voxel) const {
    if (is_empty() || std::ranges::any_of(voxel, [&](std::uint32_t at) { return at >= resolution(); }))
        return false;
    const std::uint64_t code = morton_code(voxel);
    std::uint32_t turn = root_tag; // what turns the stored node into the one that is there
    std::uint32_t node = 0;
    for (std::size_t i = levels.size(); i-- > 0;) {
        const auto there = static_cast<std::uint32_t>(code >> 3 * (i + leaf_level) & 7);
        const std::uint32_t octant = cube_group.octant[cube_group.inverse[turn]][there];
        if ((levels[i].child_masks[node] >> octant & 1) == 0)
            return false;
        const std::size_t reference = levels[i].reference(node, octant);
        turn = cube_group.product[turn][levels[i].tag(reference)];
        node = levels[i].children[reference];
    }
    return (leaves[node] >> turned_voxel(cube_group.inverse[turn], static_cast<std::uint32_t>(code & 63)) & 1) != 0;
}

static void require_usable(const DagLevel& nodes, std::size_t below_count, std::uint32_t level,
                           std::uint32_t tag_count) {
    const std::size_t count = nodes.node_count();
    require(nodes.first_children.size() == count + 1 && nodes.first_children.front() == 0 &&
                nodes.first_children.back() == nodes.children.size(),
            "voxel DAG: the references of level ", level, " do not belong to its nodes");
    for (std::size_t node = 0; node < count; ++node) {
        const auto child_count = static_cast<std::uint32_t>(std::popcount(nodes.child_masks[node]));
        require(child_count != 0 && nodes.first_children[node + 1] - nodes.first_children[node] == child_count,
                "voxel DAG: node ", node, " of level ", level, " has other references than children");
    }
    require(std::ranges::all_of(nodes.children, [&](std::uint32_t child) { return child < below_count; }),
            "voxel DAG: a child in level ", level, " is not there");
    require(tag_count == 1 ? nodes.tags.empty() : nodes.tags.size() == nodes.children.size(), "voxel DAG: level ",
            level, " has ", nodes.tags.size(), " tags for ", nodes.children.size(), " references");
    require(std::ranges::all_of(nodes.tags, [&](std::uint8_t tag) { return tag < tag_count; }),
            "voxel DAG: a tag in level ", level, " is none of the symmetry's");
}

void require_usable(const Dag& dag) {
    require(leaf_level <= dag.level && dag.level <= most_level, "voxel DAG: 2^", dag.level, " a side; from 2^",
            leaf_level, " to 2^", most_level, " are possible");
    const std::uint32_t tag_count = symmetry_order(dag.symmetry);
    require(dag.root_tag < tag_count, "voxel DAG: the root's tag is none of the symmetry's");
    require(dag.levels.size() == (dag.is_empty() ? 0 : dag.level - leaf_level), "voxel DAG: ", dag.levels.size(),
            " levels of nodes in 2^", dag.level, " voxels a side");
    require(std::ranges::find(dag.leaves, std::uint64_t{0}) == dag.leaves.end(), "voxel DAG: a leaf is empty");
    std::size_t below_count = dag.leaves.size();
    for (std::uint32_t i = 0; i < dag.levels.size(); ++i) {
        require_usable(dag.levels[i], below_count, i + leaf_level + 1, tag_count);
        below_count = dag.levels[i].node_count();
    }
    require(below_count == (dag.is_empty() ? 0 : 1), "voxel DAG: ", below_count, " roots");
}
} // namespace tyndall::voxel_dag
