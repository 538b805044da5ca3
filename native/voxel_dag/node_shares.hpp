// SPDX-License-Identifier: GPL-3.0-or-later
// What share of their sides a DAG's nodes cover, seen along each axis: made once of packed bits, for rays that stop at
// cubes of many voxels (cover_run.hpp).
// Based on: Heitz and Neyret 2012 (cover_run.hpp): coverage per direction, from the bottom up.
// Differs:  silhouettes, not sums of densities: what hides what along an axis is known. They are exact up to 16^3; above, a
//           node has 16 x 16 places per axis, each with the share that is covered there, and where a half in front and
//           one behind both cover a part of a place, they are taken as independent.
//           Bricks and 8^3 are looked at when they are met: up to 8 leaves. Of 16^3 and more, distinct nodes have 24 bits
//           each in a table without keys (retrieval_map.hpp). A file stores none of this.
// Bound:    3.7 bytes per distinct node of 16^3 and more, 4 per topmost node: some 3 MB of an estimated 0.75 million
//           for the dragon at 8K^3, made once.
#pragma once
#include "voxel_dag/axis_shares.hpp"
#include "voxel_dag/retrieval_map.hpp"
#include "voxel_dag/trace_cursor.hpp"

namespace tyndall::voxel_dag {
class NodeShares {
public:
    /// Of the DAG that the tables are of. Throws Cancelled.
    NodeShares(const TraceTables& tables, const Progress& progress);

    /// Of the node at a cursor, which has 4 voxels a side or more and is not the root.
    [[nodiscard]] HWY_INLINE AxisShares of(const TraceTables& tables, const Cursor& cursor) const {
        const std::uint32_t level = cursor.level();
        if (level > tables.bottom)
            return top_[cursor.place()];
        if (level > leaf_level + 1)
            return turned_shares(cursor.turn(), records_.at(cursor.place()));
        if (level == leaf_level + 1)
            return of_eight(tables, cursor);
        return turned_shares(cursor.turn(), shares_of_brick(tables.dag->leaves[cursor.place()]));
    }
    [[nodiscard]] std::uint64_t byte_count() const { return 4 * top_.size() + records_.byte_count(); }

private:
    /// Of 8^3, in the world.
    [[nodiscard]] static AxisShares of_eight(const TraceTables& tables, const Cursor& cursor);

    std::vector<AxisShares> top_; ///< Of topmost nodes above tables.bottom, by place, in the world.
    RetrievalMap records_;        ///< Of records of 16^3 and more, by their bit, as they are stored.
};
} // namespace tyndall::voxel_dag
