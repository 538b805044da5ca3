// SPDX-License-Identifier: GPL-3.0-or-later
// The 98 subgroups of the cube's symmetries: what may leave a node as it is, and then makes some of its tags equal.
// Based on: Jaspe, dissertation 2018, 5.4.1, whose 3 invariance bits are the subgroups that single mirrors generate.
// Differs:  all subgroups. A node that mirroring x and y together keeps, but neither alone, is not missed.
#pragma once
#include "voxel_dag/cube_group.hpp"
#include <vector>

namespace tyndall::voxel_dag {
struct Subgroups {
    std::vector<std::uint64_t> members; ///< Bit i: element i is in it. Ascending; subgroup 0 is the identity alone.
    /// Of an element followed by a subgroup's members, the smallest: coset[subgroup][element]. Two elements turn a node
    /// with this stabilizer into the same thing exactly if these are equal.
    std::vector<std::array<std::uint8_t, cube_element_count>> coset;

    /// Of members that are a subgroup.
    [[nodiscard]] std::uint8_t index_of(std::uint64_t wanted) const;
};
/// Made at the first call.
[[nodiscard]] const Subgroups& subgroups();
} // namespace tyndall::voxel_dag
