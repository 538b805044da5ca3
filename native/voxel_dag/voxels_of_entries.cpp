// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/voxels_of_entries.hpp"
#include "voxel_dag/cube_group.hpp"
#include <algorithm>
#include <bit>

namespace tyndall::voxel_dag {
namespace {
class Finding {
public:
    Finding(const PackedDag& dag, const StoredOrder& order, std::vector<Voxel>& found)
        : dag_(dag), order_(order), found_(found) {}

    /// `code`: of the node among those of its level.
    void visit(std::uint32_t level, const StoredPlace& place, std::uint64_t code,
               std::span<const std::uint64_t> entries) {
        if (level == leaf_level) {
            visit_leaf(place, code, entries);
            return;
        }
        const PackedHeader header = packed_header(dag_, level, place.node);
        // From the last child on: those behind it have taken theirs.
        for (std::uint32_t left = header.child_mask; left != 0 && !entries.empty();) {
            const auto octant = static_cast<std::uint32_t>(std::bit_width(left)) - 1;
            left &= ~(1u << octant);
            const StoredPlace child = stored_child(dag_, order_, level, place, header, octant);
            const auto begin =
                static_cast<std::size_t>(std::ranges::lower_bound(entries, child.first_entry) - entries.begin());
            if (begin < entries.size())
                visit(level - 1, child, code << 3 | cube_group.octant[place.node.turn][octant], entries.subspan(begin));
            entries = entries.first(begin);
        }
    }

private:
    void visit_leaf(const StoredPlace& place, std::uint64_t code, std::span<const std::uint64_t> entries) {
        std::uint64_t mask = pair_mask(dag_, static_cast<std::uint32_t>(place.node.bit));
        std::uint64_t entry = place.first_entry;
        const std::size_t first = found_.size();
        for (; mask != 0 && !entries.empty(); mask &= mask - 1, ++entry) {
            if (entries.front() != entry)
                continue;
            entries = entries.subspan(1);
            const auto at = static_cast<std::uint32_t>(std::countr_zero(mask));
            found_.push_back(voxel_at(code << 3 * leaf_level | turned_voxel(place.node.turn, at)));
        }
        std::reverse(found_.begin() + static_cast<std::ptrdiff_t>(first), found_.end());
    }

    const PackedDag& dag_;
    const StoredOrder& order_;
    std::vector<Voxel>& found_; ///< The last first.
};
} // namespace

std::vector<Voxel> voxels_of_entries(const PackedDag& dag, const StoredOrder& order,
                                     std::span<const std::uint64_t> entries) {
    require(entries.empty() || entries.back() < dag.voxel_count, "voxel DAG: entry ",
            entries.empty() ? 0 : entries.back(), " of ", dag.voxel_count);
    std::vector<Voxel> found;
    found.reserve(entries.size());
    if (!entries.empty())
        Finding(dag, order, found).visit(dag.level, stored_root(dag, order), 0, entries);
    std::ranges::reverse(found);
    return found;
}
} // namespace tyndall::voxel_dag
