// SPDX-License-Identifier: GPL-3.0-or-later
// A DAG as a shape of cells, so that scenes can place it: its packed bits are traced as they are.
// Bound:    rays come in floats, in metres of the object; a voxel is met where those put it, within 2^-23 of the largest
//           coordinate. The faces of a voxel are the floats nearest to where the DAG's cube has them.
#pragma once
#include "scene/cell_shape.hpp"
#include "voxel_dag/dag_file.hpp"
#include <memory>

namespace tyndall::voxel_dag {
/// `name` is for reports.
[[nodiscard]] std::unique_ptr<const CellShape> make_voxel_shape(std::shared_ptr<const PlacedDag> placed,
                                                                std::string name);
} // namespace tyndall::voxel_dag
