// SPDX-License-Identifier: GPL-3.0-or-later
// The way back from entries of an attribute array to the voxels that they are of.
// Bound:    nodes on the way to such voxels alone are opened; each asks for the places of all its children.
#pragma once
#include "voxel_dag/stored_order.hpp"

namespace tyndall::voxel_dag {
/// Entries rise, and are below the number of voxels; the voxels are in their order. `order` belongs to the DAG.
[[nodiscard]] std::vector<Voxel> voxels_of_entries(const PackedDag& dag, const StoredOrder& order,
                                                   std::span<const std::uint64_t> entries);
} // namespace tyndall::voxel_dag
