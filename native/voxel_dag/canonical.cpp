// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/canonical.hpp"
#include "voxel_dag/subgroups.hpp"
#include <algorithm>

namespace tyndall::voxel_dag {
/// elements_to_zero[octant]: a bit for each element that brings it to octant 0.
static constexpr std::array<std::uint64_t, 8> elements_to_zero = [] {
    std::array<std::uint64_t, 8> result{};
    for (std::uint32_t element = 0; element < cube_element_count; ++element)
        result[cube_group.octant[cube_group.inverse[element]][0]] |= std::uint64_t{1} << element;
    return result;
}();

/// `turns`: all elements that make the canonical form of what was given.
template <class Node>
static Canonical<Node> canonical_of(const Node& node, std::uint64_t turns) {
    const std::uint8_t back = cube_group.inverse[static_cast<std::size_t>(std::countr_zero(turns))];
    if (std::has_single_bit(turns))
        return {.node = node, .tag = back, .stabilizer = 0};
    // Back by one of the turns and there by another one leaves the canonical form as it is.
    std::uint64_t stabilizer = 0;
    for (; turns != 0; turns &= turns - 1)
        stabilizer |= std::uint64_t{1} << cube_group.product[static_cast<std::size_t>(std::countr_zero(turns))][back];
    const Subgroups& all = subgroups();
    const std::uint8_t index = all.index_of(stabilizer);
    return {.node = node, .tag = all.coset[index][back], .stabilizer = index};
}

Canonical<std::uint64_t> canonical_leaf(std::uint64_t leaf, Symmetry symmetry) {
    std::uint64_t smallest = ~std::uint64_t{0}, turns = 0;
    for (std::uint32_t permutation = 0; permutation < symmetry_order(symmetry) / 8; ++permutation) {
        std::uint64_t image = permuted_leaf(permutation, leaf);
        // One mirror leads from each reflection to the next of this order.
        for (const std::uint32_t reflections : {0u, 1u, 3u, 2u, 6u, 7u, 5u, 4u}) {
            if (reflections == 1 || reflections == 2 || reflections == 7 || reflections == 4)
                image = mirror_x(image);
            else if (reflections == 3 || reflections == 5)
                image = mirror_y(image);
            else if (reflections == 6)
                image = mirror_z(image);
            const std::uint64_t turn = std::uint64_t{1} << (8 * permutation + reflections);
            turns = image < smallest ? turn : image == smallest ? turns | turn : turns;
            smallest = std::min(smallest, image);
        }
    }
    return canonical_of(smallest, turns);
}

Canonical<TurnedChildren> canonical_node(const TurnedChildren& node, const std::array<std::uint8_t, 8>& stabilizers,
                                         Symmetry symmetry) {
    const Subgroups& all = subgroups();
    std::uint32_t smallest_child = ~0u;
    for (const std::uint32_t child : node.children)
        smallest_child = std::min(smallest_child, child - 1); // none, 0, is the largest
    ++smallest_child;
    const auto turn_tags = [&](std::uint32_t element) {
        std::array<std::uint8_t, 8> tags{};
        for (std::uint32_t octant = 0; octant < 8; ++octant)
            if (node.children[octant] != 0)
                tags[cube_group.octant[element][octant]] =
                    all.coset[stabilizers[octant]][cube_group.product[element][node.tags[octant]]];
        return tags;
    };
    std::uint64_t turns = 0;
    for (std::uint32_t anchor = 0; anchor < 8; ++anchor)
        turns |= node.children[anchor] == smallest_child ? elements_to_zero[anchor] : 0;
    turns &= (std::uint64_t{1} << symmetry_order(symmetry)) - 1;
    // Octant by octant of the image those stay that have the smallest child there: most nodes are decided by two or three.
    for (std::uint32_t octant = 1; octant < 8 && !std::has_single_bit(turns); ++octant) {
        std::uint32_t least = ~0u;
        for (std::uint64_t left = turns; left != 0; left &= left - 1) {
            const auto element = static_cast<std::uint32_t>(std::countr_zero(left));
            const std::uint32_t child = node.children[cube_group.octant[cube_group.inverse[element]][octant]];
            const std::uint64_t bit = left & (~left + 1);
            turns = child < least ? turns & ~(bit - 1) : child > least ? turns & ~bit : turns;
            least = std::min(least, child);
        }
    }
    const auto first = static_cast<std::uint32_t>(std::countr_zero(turns));
    TurnedChildren best{.children = {}, .tags = turn_tags(first)};
    for (std::uint32_t octant = 0; octant < 8; ++octant)
        best.children[cube_group.octant[first][octant]] = node.children[octant];
    for (std::uint64_t left = turns & (turns - 1); left != 0; left &= left - 1) {
        const std::array<std::uint8_t, 8> tags = turn_tags(static_cast<std::uint32_t>(std::countr_zero(left)));
        const std::uint64_t bit = left & (~left + 1);
        if (tags < best.tags)
            turns &= ~(bit - 1); // none before
        else if (tags != best.tags)
            turns &= ~bit;
        best.tags = std::min(tags, best.tags);
    }
    return canonical_of(best, turns);
}
} // namespace tyndall::voxel_dag
