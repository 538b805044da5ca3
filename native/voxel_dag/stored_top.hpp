// SPDX-License-Identifier: GPL-3.0-or-later
// Which topmost levels a file has beside its records: as far as they take little, and as all have colours if voxels do.
// Bound:    top_levels.hpp's; one mean is looked up for each cube.
#pragma once
#include "voxel_dag/top_levels.hpp"

namespace tyndall::voxel_dag {
/// Of the geometry's bytes: topmost levels take less than one part of so many.
inline constexpr std::uint64_t top_share = 128;

/// Of voxels that carry nothing.
[[nodiscard]] std::vector<TopLevel> stored_top(const PackedDag& dag, const Progress& progress);
/// mean_indices: the numbers of means, run_array.hpp's bytes, which need not be those of the parts; or none.
[[nodiscard]] std::vector<TopLevel> stored_top(const PackedDag& dag, const AttributeParts& attributes,
                                               std::span<const std::uint8_t> mean_indices, const Progress& progress);
} // namespace tyndall::voxel_dag
