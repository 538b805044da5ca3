// SPDX-License-Identifier: GPL-3.0-or-later
// A DAG's topmost levels one by one, coarsest first: what a reader takes of a large file before, or instead of, the rest.
// Based on: the octree without pointers (Jaspe, dissertation 2018, 5.6.3): a byte per node.
// Differs:  records cannot be cut by levels, as most lie inside one record, the root's; so these are stored beside them, as
//           far as they take little. Colours are means, by level.
// Bound:    a byte per cube of the level above; 3 more per cube where there are colours.
#pragma once
#include "voxel_dag/dag_attributes.hpp"
#include <functional>

namespace tyndall::voxel_dag {
/// Cubes of which 2^level lie along a side.
struct TopLevel {
    std::vector<std::uint8_t>
        child_masks;               ///< Of the cubes of the level above, in Morton order: which octants have voxels.
    std::vector<ByteColor> colors; ///< Means of these cubes, in Morton order; or none.

    bool operator==(const TopLevel&) const = default;
};
struct TopLevelsConfig {
    std::uint32_t most_level = voxel_dag::most_level;
    std::uint64_t most_bytes = std::uint64_t{1} << 40; ///< Without colours.
};
/// Of cubes of 2^side_level voxels a side, by the lowest voxel of each; or nothing, for cubes that have none.
using ColorsOfCubes = std::function<std::vector<ByteColor>(std::span<const Voxel> lowest, std::uint32_t side_level)>;
/// [i]: level i + 1, as far as the configuration allows. colors: empty, where voxels have none.
[[nodiscard]] std::vector<TopLevel> top_levels_of(const PackedDag& dag, const ColorsOfCubes& colors,
                                                  const TopLevelsConfig& config, const Progress& progress);

/// The cubes of the last of these levels as voxels, 2^levels.size() a side: at least leaf_level. Throws InvalidInput where
/// a level does not belong to the one above.
[[nodiscard]] LeafMasks voxels_of(std::span<const TopLevel> levels);
/// Throws InvalidInput where these are not the cubes of the DAG, or where colours are not as many, and Cancelled.
void require_top_of(const PackedDag& dag, std::span<const TopLevel> levels, const Progress& progress);
} // namespace tyndall::voxel_dag
