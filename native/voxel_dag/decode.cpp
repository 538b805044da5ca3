// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/decode.hpp"
#include "core/errors.hpp"

namespace tyndall::voxel_dag {
template <class Tree>
Decoder<Tree>::Decoder(const Tree& tree) : tree_(tree), level_(tree.level), is_done_(tree.is_empty()) {
    if (level_ > leaf_level && !is_done_)
        enter(0, root_of(tree));
}

template <class Tree>
void Decoder<Tree>::enter(std::uint64_t code, const Place& place) {
    step() = {.code = code, .place = place, .open = opened(tree_, level_, place), .octant = 0};
}

template <class Tree>
void Decoder<Tree>::add(std::uint64_t code, const Place& place, LeafMasks& part) const {
    const TurnedLeaf leaf = leaf_of(tree_, place);
    part.codes.push_back(code);
    part.masks.push_back(turned_leaf(leaf.turn, leaf.mask));
}

template <class Tree>
bool Decoder<Tree>::next(std::size_t most_bricks, LeafMasks& part) {
    part.level = tree_.level;
    part.codes.clear(), part.masks.clear();
    if (!is_done_ && tree_.level == leaf_level) {
        add(0, root_of(tree_), part);
        is_done_ = true;
    }
    while (!is_done_ && part.codes.size() < most_bricks) {
        Step& at = step();
        if (at.octant == 8) {
            is_done_ = level_++ == tree_.level;
            continue;
        }
        const std::uint32_t there = at.octant++;
        const std::uint32_t octant = cube_group.octant[cube_group.inverse[at.place.turn]][there];
        if ((at.open.child_mask >> octant & 1) == 0)
            continue;
        const Place child = child_of(tree_, level_, at.place, at.open, octant);
        const std::uint64_t code = at.code << 3 | there;
        if (level_ == leaf_level + 1) {
            add(code, child, part);
            continue;
        }
        --level_;
        enter(code, child);
    }
    return !part.codes.empty();
}
template class Decoder<Dag>;
template class Decoder<PackedDag>;

template <class Tree>
static void decode_tree(const Tree& tree, std::size_t part_size,
                        const std::function<void(const LeafMasks& part)>& receive, const Progress& progress) {
    require(part_size > 0, "voxel DAG: decoded in parts of 0 bricks");
    Decoder<Tree> decoder(tree);
    for (LeafMasks part; decoder.next(part_size, part);) {
        progress.poll();
        receive(part);
    }
}
void decode(const Dag& dag, std::size_t part_size, const std::function<void(const LeafMasks& part)>& receive,
            const Progress& progress) {
    decode_tree(dag, part_size, receive, progress);
}
void decode(const PackedDag& dag, std::size_t part_size, const std::function<void(const LeafMasks& part)>& receive,
            const Progress& progress) {
    decode_tree(dag, part_size, receive, progress);
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
