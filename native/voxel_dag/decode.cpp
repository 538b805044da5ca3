// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/decode.hpp"
#include "voxel_dag/cube_group.hpp"

namespace tyndall::voxel_dag {
Decoder::Decoder(const Dag& dag) : dag_(dag), depth_(dag.levels.size()), is_done_(dag.is_empty()) {
    if (depth_ > 0)
        steps_[depth_ - 1] = {0, 0, dag.root_tag, 0};
}

void Decoder::add(std::uint64_t code, std::uint32_t leaf, std::uint32_t turn, LeafMasks& part) const {
    part.codes.push_back(code);
    part.masks.push_back(turned_leaf(turn, dag_.leaves[leaf]));
}

bool Decoder::next(std::size_t most_bricks, LeafMasks& part) {
    part.level = dag_.level;
    part.codes.clear(), part.masks.clear();
    if (!is_done_ && dag_.levels.empty()) {
        add(0, 0, dag_.root_tag, part);
        is_done_ = true;
    }
    while (!is_done_ && part.codes.size() < most_bricks) {
        Step& step = steps_[depth_ - 1];
        if (step.octant == 8) {
            is_done_ = depth_ == dag_.levels.size();
            ++depth_;
            continue;
        }
        const DagLevel& nodes = dag_.levels[depth_ - 1];
        const std::uint32_t there = step.octant++;
        const std::uint32_t octant = cube_group.octant[cube_group.inverse[step.turn]][there];
        if ((nodes.child_masks[step.node] >> octant & 1) == 0)
            continue;
        const std::size_t reference = nodes.reference(step.node, octant);
        const std::uint32_t child = nodes.children[reference];
        const std::uint32_t turn = cube_group.product[step.turn][nodes.tag(reference)];
        if (depth_ == 1)
            add(step.code << 3 | there, child, turn, part);
        else
            steps_[--depth_ - 1] = {step.code << 3 | there, child, turn, 0};
    }
    return !part.codes.empty();
}

void decode(const Dag& dag, std::size_t part_size, const std::function<void(const LeafMasks& part)>& receive,
            const Progress& progress) {
    require(part_size > 0, "voxel DAG: decoded in parts of 0 bricks");
    Decoder decoder(dag);
    for (LeafMasks part; decoder.next(part_size, part);) {
        progress.poll();
        receive(part);
    }
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
