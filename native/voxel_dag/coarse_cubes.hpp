// SPDX-License-Identifier: GPL-3.0-or-later
// A coarse picture of a DAG's voxels: the cubes of one level that are not empty, as fine as a number of them allows.
// Bound:    as many nodes are opened as there are cubes and their ancestors, however many voxels lie in them.
#pragma once
#include "core/progress.hpp"
#include "voxel_dag/packed_dag.hpp"

namespace tyndall::voxel_dag {
struct CoarseCubes {
    std::uint32_t level = 0;          ///< The whole has 2^level cubes a side.
    std::vector<std::uint64_t> codes; ///< Morton codes in that grid, rising.
};
/// Of `level` or of the DAG's own, whichever is less; of a lower one where there would be more than most_cubes. A DAG that
/// is not usable (require_usable()) is no input. Throws Cancelled.
[[nodiscard]] CoarseCubes coarse_cubes(const PackedDag& dag, std::uint32_t level, std::size_t most_cubes,
                                       const Progress& progress);
} // namespace tyndall::voxel_dag
