// SPDX-License-Identifier: GPL-3.0-or-later
// What the files that bind voxel DAGs share.
#pragma once
#include "bindings/bind.hpp"
#include "voxel_dag/build_dag.hpp"
#include "voxel_dag/dag_file.hpp"
#include "voxel_dag/merge_symmetric.hpp"
#include <array>
#include <optional>
#include <utility>

namespace tyndall::bindings {
using VoxelDagClass = py::class_<voxel_dag::PlacedDag, std::shared_ptr<voxel_dag::PlacedDag>>;

using Bounds = std::pair<std::array<double, 3>, double>; ///< Lower corner and side.
inline voxel_dag::Cube cube_of(const Bounds& bounds) {
    const auto& [lower_m, side_m] = bounds;
    return {.lower_m = dvec3(lower_m[0], lower_m[1], lower_m[2]), .side_m = side_m};
}

/// Each in a file of its name. Those of a class add to it.
void bind_voxelize(py::module_& native);
void bind_out_of_core(py::module_& native);
void bind_voxel_counts(py::module_& native, VoxelDagClass& type);
void bind_voxel_preview(VoxelDagClass& type);
void bind_voxel_trace(VoxelDagClass& type);
void bind_voxel_export(VoxelDagClass& type);
void bind_voxel_attributes(VoxelDagClass& type);
} // namespace tyndall::bindings
