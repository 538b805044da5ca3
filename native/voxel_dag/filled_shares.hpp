// SPDX-License-Identifier: GPL-3.0-or-later
// How much of each box of a lattice a closed mesh fills.
// Based on: solid_fill.hpp: centres between two crossings of a column lie within.
// Differs:  a box is seen by 4 x 4 columns along the lattice's longest side, each cut to 1/16 of the box: no voxels are
//           made, and boxes may have any sides.
// Bound:    as column_crossings.hpp, for 16 times as many columns as the lattice has; one addition per box and column in
//           it. 4 bytes per box.
#pragma once
#include "core/math.hpp"
#include "core/progress.hpp"
#include <span>
#include <vector>

namespace tyndall::voxel_dag {
struct BoxLattice {
    dvec3 lower_m{0.0};
    dvec3 step_m{1.0}; ///< Sides of a box, above 0.
    uvec3 counts{1};   ///< Boxes along each axis, [1, 8192].
};
/// Box after box, z fastest, in [0, 1]. Parts of the mesh that overlap count once.
/// Throws InvalidInput, which names the setting, a vertex or an edge at which the mesh is open; and Cancelled.
[[nodiscard]] std::vector<float> filled_shares(std::span<const vec3> positions_m, std::span<const uvec3> triangles,
                                               const BoxLattice& lattice, const Progress& progress);
} // namespace tyndall::voxel_dag
