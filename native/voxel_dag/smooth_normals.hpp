// SPDX-License-Identifier: GPL-3.0-or-later
// Normals for voxels that carry none: across the plane that fits the voxels around each one best.
// Based on: Jaspe, dissertation 2018, 5.5 and 5.9: normals for geometry alone. Hoppe et al., Surface Reconstruction from
//           Unorganized Points, SIGGRAPH 1992, 3.2: the direction of least variance.
// Differs:  from the voxels, not from a depth buffer: reflected rays have normals, too, and a picture's do not swim. Not the
//           gradient of occupancy: a voxelized surface is a shell, on both sides of which there is nothing. Of a solid the
//           direction of least variance is the gradient's. Voxels weigh (1 - d^2 / (radius + 1)^2)^2.
// Bound:    a look for each brick of 4^3 around, at radius 3 8 to 27: 0.1 to 0.3 us each.
#pragma once
#include "core/math.hpp"
#include "core/progress.hpp"
#include "voxel_dag/packed_dag.hpp"
#include <span>

namespace tyndall::voxel_dag::smooth_normals {
struct Config {
    std::uint32_t radius = 3; ///< In voxels, [1, 16].
};
/// Unit vectors, or 0 where no direction has less variance than others: a voxel alone, a line, the inside of a solid. They
/// look against directions, one per voxel; without any, to where fewer voxels are: out of a solid, while a shell has no such
/// side. Throws InvalidInput and Cancelled.
[[nodiscard]] std::vector<vec3> find(const PackedDag& dag, std::span<const Voxel> voxels,
                                     std::span<const dvec3> directions, const Config& config, const Progress& progress);
} // namespace tyndall::voxel_dag::smooth_normals
