// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/decode.hpp"
#include "voxel_dag/cube_group.hpp"
#include <array>

namespace tyndall::voxel_dag {
void decode(const Dag& dag, std::size_t part_size, const std::function<void(const LeafMasks& part)>& receive,
            const Progress& progress) {
    require(part_size > 0, "voxel DAG: decoded in parts of 0 bricks");
    if (dag.is_empty())
        return;
    LeafMasks part{.level = dag.level, .codes = {}, .masks = {}};
    const auto hand_over = [&] {
        progress.poll();
        receive(part);
        part.codes.clear(), part.masks.clear();
    };
    const auto add = [&](std::uint64_t code, std::uint32_t leaf, std::uint32_t turn) {
        part.codes.push_back(code);
        part.masks.push_back(turned_leaf(turn, dag.leaves[leaf]));
        if (part.codes.size() == part_size)
            hand_over();
    };
    // A node on the way down, and the next of its octants, as they lie in the world.
    struct Step {
        std::uint64_t code;
        std::uint32_t node, turn, octant;
    };
    std::array<Step, most_level - leaf_level> steps;
    std::size_t i = dag.levels.size(); // levels[i - 1] is at work
    if (i == 0)
        add(0, 0, dag.root_tag);
    else
        steps[i - 1] = {0, 0, dag.root_tag, 0};
    while (i > 0 && i <= dag.levels.size()) {
        Step& step = steps[i - 1];
        if (step.octant == 8) {
            ++i;
            continue;
        }
        const DagLevel& nodes = dag.levels[i - 1];
        const std::uint32_t there = step.octant++;
        const std::uint32_t octant = cube_group.octant[cube_group.inverse[step.turn]][there];
        if ((nodes.child_masks[step.node] >> octant & 1) == 0)
            continue;
        const std::size_t reference = nodes.reference(step.node, octant);
        const std::uint32_t child = nodes.children[reference];
        const std::uint32_t turn = cube_group.product[step.turn][nodes.tag(reference)];
        if (i == 1)
            add(step.code << 3 | there, child, turn);
        else
            steps[--i - 1] = {step.code << 3 | there, child, turn, 0};
    }
    if (!part.codes.empty())
        hand_over();
}

LeafMasks decode(const Dag& dag, const Progress& progress) {
    LeafMasks all{.level = dag.level, .codes = {}, .masks = {}};
    decode(
        dag, 1 << 16,
        [&](const LeafMasks& part) {
            all.codes.insert(all.codes.end(), part.codes.begin(), part.codes.end());
            all.masks.insert(all.masks.end(), part.masks.begin(), part.masks.end());
        },
        progress);
    return all;
}
} // namespace tyndall::voxel_dag
