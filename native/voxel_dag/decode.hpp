// SPDX-License-Identifier: GPL-3.0-or-later
// From a DAG back to the voxels that it was made of, in Morton order, a part at a time.
// Bound:    one step per node and brick of the tree; memory for one part.
#pragma once
#include "core/progress.hpp"
#include "voxel_dag/dag.hpp"
#include <functional>

namespace tyndall::voxel_dag {
/// Calls receive with one part after another: at least one brick each, and at most part_size. A DAG that is not usable
/// (require_usable()) is no input. Throws Cancelled.
void decode(const Dag& dag, std::size_t part_size, const std::function<void(const LeafMasks& part)>& receive,
            const Progress& progress);
/// All at once.
[[nodiscard]] LeafMasks decode(const Dag& dag, const Progress& progress);
} // namespace tyndall::voxel_dag
