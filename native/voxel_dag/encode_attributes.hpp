// SPDX-License-Identifier: GPL-3.0-or-later
// Attributes of voxels in Morton order -> bytes in the order of a packed DAG (dag_attributes.hpp).
// Based on: Kol, dissertation 2018, 2.4.2, 2.4.3 and 2.5.2: joint materials; fewer colours; normals of fewer bits.
// Bound:    16 bytes per voxel, and 4 per channel, beside the attributes, while materials are found and put in order.
#pragma once
#include "voxel_dag/dag_attributes.hpp"

namespace tyndall::voxel_dag {
/// As they are, every value comes back as it was given.
struct AttributeConfig {
    std::uint32_t color_count = 0;      ///< At most so many colours, [1, 65536]; 0: as many as there are.
    double most_color_difference = 0.0; ///< CIE94, of any voxel's colour, [0.01, 100]; 0: none. One of both at most.
    std::uint32_t normal_bits = 32;     ///< [8, 32]: 32 keeps the codes.
    bool has_means = true;              ///< Of nodes of 16^3 and more, for levels of detail.
};
/// Of the DAG's voxels. The same bytes for any number of threads; means are those of what was given. Throws InvalidInput,
/// which names the array or the setting, and Cancelled.
[[nodiscard]] std::shared_ptr<const DagAttributes> encode_attributes(const PackedDag& dag,
                                                                     const VoxelAttributes& attributes,
                                                                     const AttributeConfig& config,
                                                                     const Progress& progress);
} // namespace tyndall::voxel_dag
