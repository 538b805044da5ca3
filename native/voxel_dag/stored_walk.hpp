// SPDX-License-Identifier: GPL-3.0-or-later
// A walk over the tree that a packed DAG stands for, or over a part of it, which knows of each node where its voxels and
// numbered nodes begin in Morton order and in stored order: subtrees are visited side by side.
#pragma once
#include "core/parallel.hpp"
#include "voxel_dag/cube_group.hpp"
#include "voxel_dag/stored_order.hpp"

namespace tyndall::voxel_dag {
/// Where a subtree lies in Morton order.
struct MortonPlace {
    std::uint64_t first_voxel = 0;
    std::uint64_t number = 0; ///< Among the numbered nodes, each before its children, as they lie in the world.
};
/// The children of a node that are there.
struct StoredChildren {
    std::uint32_t child_mask = 0; ///< By the record's octants, as all that follows.
    std::array<StoredPlace, 8> places;
    std::array<std::uint64_t, 8> voxel_counts{};
    std::array<std::uint64_t, 8> node_counts{}; ///< Numbered ones, they themselves among them.
};
/// Of a node of 8^3 or more.
[[nodiscard]] inline StoredChildren stored_children(const PackedDag& dag, const StoredOrder& order,
                                                    const StoredSubtree& at) {
    const PackedHeader header = packed_header(dag, at.level, at.place.node);
    StoredChildren children{.child_mask = header.child_mask, .places = {}};
    std::uint64_t past = at.place.first_entry + at.voxel_count, past_number = at.place.number + at.node_count;
    for (std::uint32_t octant = 8; octant-- > 0;)
        if ((header.child_mask >> octant & 1) != 0) {
            const StoredPlace& child = children.places[octant] =
                stored_child(dag, order, at.level, at.place, header, octant);
            children.voxel_counts[octant] = past - child.first_entry;
            past = child.first_entry;
            if (at.level > least_mean_level) {
                children.node_counts[octant] = past_number - child.number;
                past_number = child.number;
            }
        }
    return children;
}

/// Visitor: Sum, what a subtree adds up to; least_level, where the walk ends;
///   Sum at_end(place, morton place, voxel_count): a node of least_level;
///   Sum joined(place, morton place, children): of the Sums of a node's children, by octant as they lie in the world.
/// Both are called by many threads, each node's once.
template <class Visitor>
class StoredWalk {
public:
    using Sum = typename Visitor::Sum;
    StoredWalk(const PackedDag& dag, const StoredOrder& order, const Visitor& visitor, const Progress& progress)
        : dag_(dag), order_(order), visitor_(visitor), progress_(progress) {}

    /// Of least_level or more. Morton places count from the subtree's begin.
    Sum run(const StoredSubtree& subtree) const { return visit(subtree, {}); }

private:
    static constexpr std::uint32_t least_parallel_level = 9; // below, a node is some ms of work

    Sum visit(const StoredSubtree& at, const MortonPlace& morton) const {
        if (at.level == Visitor::least_level)
            return visitor_.at_end(at.place, morton, at.voxel_count);
        const StoredChildren children = stored_children(dag_, order_, at);
        std::array<MortonPlace, 8> places; // by octants of the world
        std::array<Sum, 8> sums{};         // likewise
        MortonPlace next{.first_voxel = morton.first_voxel, .number = morton.number + 1};
        for (std::uint32_t there = 0; there < 8; ++there) {
            places[there] = next;
            next.first_voxel += children.voxel_counts[octant_at(at.place, there)];
            next.number += children.node_counts[octant_at(at.place, there)];
        }
        const auto visit_octant = [&](std::size_t there) {
            const std::uint32_t octant = octant_at(at.place, static_cast<std::uint32_t>(there));
            if ((children.child_mask >> octant & 1) != 0)
                sums[there] = visit({.level = at.level - 1,
                                     .place = children.places[octant],
                                     .voxel_count = children.voxel_counts[octant],
                                     .node_count = children.node_counts[octant]},
                                    places[there]);
        };
        if (at.level >= least_parallel_level)
            parallel_for(8, progress_, visit_octant, 1);
        else
            for (std::size_t there = 0; there < 8; ++there)
                visit_octant(there);
        return visitor_.joined(at.place, morton, sums);
    }
    static std::uint32_t octant_at(const StoredPlace& place, std::uint32_t there) {
        return cube_group.octant[cube_group.inverse[place.node.turn]][there];
    }

    const PackedDag& dag_;
    const StoredOrder& order_;
    const Visitor& visitor_;
    const Progress& progress_;
};
} // namespace tyndall::voxel_dag
