// SPDX-License-Identifier: GPL-3.0-or-later
// A surface whose arrays are numpy's.
#pragma once
#include "voxel_dag/surface_attributes.hpp"
#include <pybind11/numpy.h>

namespace tyndall::bindings {
struct VoxelSurface {
    std::vector<pybind11::array> arrays; ///< What `surface` refers to.
    std::vector<voxel_dag::SurfaceMaterial> materials;
    voxel_dag::Surface surface;
};
void bind_voxel_surface(pybind11::module_& native);
} // namespace tyndall::bindings
