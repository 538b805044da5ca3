// SPDX-License-Identifier: GPL-3.0-or-later
// What the voxels of sub-cubes carry, in their files -> the attributes of the whole, in the order of its packed DAG.
// Differs:  a sub-cube's voxels follow each other in stored order, too: parts are read one by one, in the order of their
//           entries, and what they become is written as it comes. Materials and palettes are made of the parts' tables
//           alone. The bytes are those that encode_attributes() makes of all voxels at once.
// Bound:    8 bytes per voxel of the largest part; the tables of different materials; 64 MiB for equal blocks. Beside them
//           what is written, on the disk of `folder`.
#pragma once
#include "voxel_dag/dag_file.hpp"
#include "voxel_dag/part_file.hpp"

namespace tyndall::voxel_dag {
struct JoinAttributesConfig {
    AttributeLayout layout;     ///< Of the parts, too.
    AttributeConfig attributes; ///< Its budget is for all of this, and for the DAG and its order beside it.
    std::uint32_t part_level = leaf_level;
    std::filesystem::path folder; ///< For what is written before it is known how much it is.
};
/// Of parts in the order of their codes, one of which has voxels at least; dag is what their DAGs make. report(share of the
/// work that is done). Throws InvalidInput where the budget does not suffice; IoError; and Cancelled.
[[nodiscard]] StreamedAttributes join_attributes(std::span<const PartFile> parts, const PackedDag& dag,
                                                 const JoinAttributesConfig& config, const Progress& progress,
                                                 const std::function<void(double)>& report);
} // namespace tyndall::voxel_dag
