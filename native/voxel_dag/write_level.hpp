// SPDX-License-Identifier: GPL-3.0-or-later
// One level of a DAG from records of eight children each, in parallel: a count by block says where each one writes.
#pragma once
#include "core/parallel.hpp"
#include "voxel_dag/dag.hpp"

namespace tyndall::voxel_dag {
using Children = std::array<std::uint32_t, 8>; ///< Numbers in the level below, by octant, from 1 on; 0: none there.
struct TurnedChildren {
    Children children;
    std::array<std::uint8_t, 8> tags; ///< 0 where there is no child.
};
inline const Children& children_of(const Children& node) { return node; }
inline const Children& children_of(const TurnedChildren& node) { return node.children; }

/// Of `count` nodes, record_of(node); a child of number n becomes n - first_number.
template <class RecordOf>
[[nodiscard]] DagLevel written_level(std::size_t count, const RecordOf& record_of, std::uint32_t first_number,
                                     const Progress& progress) {
    constexpr bool has_tags = requires { record_of(0).tags; };
    constexpr std::size_t block = 1 << 12;
    DagLevel level;
    level.child_masks.resize(count);
    level.first_children.resize(count + 1);
    std::vector<std::uint32_t> begins((count + block - 1) / block + 1, 0);
    parallel_blocks(count, block, progress, [&](std::size_t begin, std::size_t end) {
        std::uint32_t child_count = 0;
        for (std::size_t node = begin; node < end; ++node) {
            const Children& children = children_of(record_of(node));
            std::uint32_t mask = 0;
            for (std::uint32_t octant = 0; octant < 8; ++octant)
                mask |= std::uint32_t{children[octant] != 0} << octant;
            level.child_masks[node] = static_cast<std::uint8_t>(mask);
            child_count += static_cast<std::uint32_t>(std::popcount(mask));
        }
        begins[begin / block + 1] = child_count;
    });
    for (std::size_t i = 1; i < begins.size(); ++i)
        begins[i] += begins[i - 1];
    level.first_children.back() = begins.back();
    level.children.resize(begins.back());
    if constexpr (has_tags)
        level.tags.resize(begins.back());
    parallel_blocks(count, block, progress, [&](std::size_t begin, std::size_t end) {
        std::uint32_t at = begins[begin / block];
        for (std::size_t node = begin; node < end; ++node) {
            const auto& record = record_of(node);
            level.first_children[node] = at;
            // Each place is written, and kept where there is a child: a branch would be as good as random.
            Children children;
            std::array<std::uint8_t, 8> tags;
            std::uint32_t count_here = 0;
            for (std::uint32_t octant = 0; octant < 8; ++octant) {
                const std::uint32_t child = children_of(record)[octant];
                children[count_here] = child - first_number;
                if constexpr (has_tags)
                    tags[count_here] = record.tags[octant];
                count_here += child != 0;
            }
            std::copy_n(children.begin(), count_here, level.children.begin() + at);
            if constexpr (has_tags)
                std::copy_n(tags.begin(), count_here, level.tags.begin() + at);
            at += count_here;
        }
    });
    return level;
}
} // namespace tyndall::voxel_dag
