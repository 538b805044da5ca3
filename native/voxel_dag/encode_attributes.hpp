// SPDX-License-Identifier: GPL-3.0-or-later
// Attributes of voxels in Morton order -> bytes in the order of a packed DAG (dag_attributes.hpp).
// Bound:    what given_materials.hpp says, beside the attributes, while materials are found and put in order.
#pragma once
#include "voxel_dag/given_materials.hpp"

namespace tyndall::voxel_dag {
/// Of the DAG's voxels. The same bytes for any number of threads; means are those of what was given. Throws InvalidInput,
/// which names the array or the setting, or says that the budget does not suffice; and Cancelled.
[[nodiscard]] std::shared_ptr<const DagAttributes> encode_attributes(const PackedDag& dag,
                                                                     const VoxelAttributes& attributes,
                                                                     const AttributeConfig& config,
                                                                     const Progress& progress);
} // namespace tyndall::voxel_dag
