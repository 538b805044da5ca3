// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/voxels_of_entries.hpp"
#include "voxel_dag/cube_group.hpp"
#include <algorithm>
#include <array>
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
        std::array<StoredPlace, 8> children;
        std::array<std::uint64_t, 8> codes{};
        std::size_t count = 0;
        for (std::uint32_t left = header.child_mask; left != 0; left &= left - 1, ++count) {
            const auto octant = static_cast<std::uint32_t>(std::countr_zero(left));
            children[count] = stored_child(dag_, order_, level, place, header, octant);
            codes[count] = code << 3 | cube_group.octant[place.node.turn][octant];
        }
        for (std::size_t child = 0; child < count && !entries.empty(); ++child) {
            const auto end =
                child + 1 < count ? std::ranges::lower_bound(entries, children[child + 1].first_entry) : entries.end();
            const auto own_count = static_cast<std::size_t>(end - entries.begin());
            if (own_count > 0)
                visit(level - 1, children[child], codes[child], entries.first(own_count));
            entries = entries.subspan(own_count);
        }
    }

private:
    void visit_leaf(const StoredPlace& place, std::uint64_t code, std::span<const std::uint64_t> entries) {
        std::uint64_t mask = pair_mask(dag_, static_cast<std::uint32_t>(place.node.bit));
        std::uint64_t entry = place.first_entry;
        for (; mask != 0 && !entries.empty(); mask &= mask - 1, ++entry) {
            if (entries.front() != entry)
                continue;
            entries = entries.subspan(1);
            const auto at = static_cast<std::uint32_t>(std::countr_zero(mask));
            found_.push_back(voxel_at(code << 3 * leaf_level | turned_voxel(place.node.turn, at)));
        }
    }

    const PackedDag& dag_;
    const StoredOrder& order_;
    std::vector<Voxel>& found_;
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
    return found;
}
} // namespace tyndall::voxel_dag
