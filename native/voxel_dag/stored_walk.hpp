// SPDX-License-Identifier: GPL-3.0-or-later
// A walk over the tree that a packed DAG stands for, which knows of each node where its voxels begin in Morton order and in
// stored order: subtrees are visited side by side.
#pragma once
#include "core/parallel.hpp"
#include "voxel_dag/cube_group.hpp"
#include "voxel_dag/stored_order.hpp"

namespace tyndall::voxel_dag {
/// Visitor: Sum, what a subtree adds up to; least_level, where the walk ends;
///   Sum at_end(place, first_voxel, voxel_count): a node of least_level, its voxels counted in Morton order from
///     first_voxel on;
///   Sum joined(place, children): of the Sums of a node's children, by octant as they lie in the world.
/// Both are called by many threads, each node's once.
template <class Visitor>
class StoredWalk {
public:
    using Sum = typename Visitor::Sum;
    StoredWalk(const PackedDag& dag, const StoredOrder& order, const Visitor& visitor, const Progress& progress)
        : dag_(dag), order_(order), visitor_(visitor), progress_(progress) {}

    /// The root has least_level or more.
    Sum run() const { return visit(dag_.level, stored_root(dag_, order_), 0, dag_.voxel_count); }

private:
    static constexpr std::uint32_t least_parallel_level = 9; // below, a node is some ms of work

    Sum visit(std::uint32_t level, const StoredPlace& place, std::uint64_t first_voxel,
              std::uint64_t voxel_count) const {
        if (level == Visitor::least_level)
            return visitor_.at_end(place, first_voxel, voxel_count);
        const PackedHeader header = packed_header(dag_, level, place.node);
        std::array<StoredPlace, 8> places;           // by the record's octants
        std::array<std::uint64_t, 8> voxel_counts{}; // as many
        std::uint64_t past = place.first_entry + voxel_count;
        for (std::uint32_t octant = 8; octant-- > 0;)
            if ((header.child_mask >> octant & 1) != 0) {
                places[octant] = stored_child(dag_, order_, level, place, header, octant);
                voxel_counts[octant] = past - places[octant].first_entry;
                past = places[octant].first_entry;
            }
        std::array<std::uint64_t, 8> first_voxels{};
        std::array<Sum, 8> sums{}; // by octants of the world
        for (std::uint32_t there = 0; there < 8; ++there) {
            first_voxels[there] = first_voxel;
            first_voxel += voxel_counts[octant_at(place, there)];
        }
        const auto visit_octant = [&](std::size_t there) {
            const std::uint32_t octant = octant_at(place, static_cast<std::uint32_t>(there));
            if (voxel_counts[octant] != 0)
                sums[there] = visit(level - 1, places[octant], first_voxels[there], voxel_counts[octant]);
        };
        if (level >= least_parallel_level)
            parallel_for(8, progress_, visit_octant, 1);
        else
            for (std::size_t there = 0; there < 8; ++there)
                visit_octant(there);
        return visitor_.joined(place, sums);
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
