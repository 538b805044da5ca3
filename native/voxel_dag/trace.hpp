// SPDX-License-Identifier: GPL-3.0-or-later
// The first voxel along a ray, in a DAG's arrays or in its packed bits: one ray, and what tracer.hpp does for many must equal.
// Based on: Jaspe, dissertation 2018, 5.5.1, "transforming the geometry": the ray stays, octants are turned.
// Differs:  the turn is any of 48. The parameter at which a ray crosses a plane is computed from the plane each time, never
//           added up, so that a node's interval holds those of its children exactly, and the result is that of testing
//           each voxel by itself, bit by bit.
// Bound:    per node on the way 3 multiplications and, per child, one step.
#pragma once
#include "core/math.hpp"
#include "core/progress.hpp"
#include "voxel_dag/packed_dag.hpp"
#include <limits>
#include <span>

namespace tyndall::voxel_dag {
class NodeShares; // node_shares.hpp

/// In voxels: voxel (x, y, z) is the cube from there to (x + 1, y + 1, z + 1).
struct VoxelRay {
    dvec3 origin;
    dvec3 direction;                                      ///< Of any length.
    double end = std::numeric_limits<double>::infinity(); ///< In lengths of direction: what begins beyond is not hit.
    /// Level of detail: a cube that is no wider than `width`, or than `spread` times the distance to it, is hit where it has
    /// any voxel, and not looked into. In voxels, and in voxels per length of direction. The whole is always looked into.
    double width = 0.0, spread = 0.0;
    double start = 0.0; ///< At least 0, in lengths of direction: it begins there.
    /// Of the same DAG: such cubes, of 4^3 voxels and more, are hit by as many rays as their voxels would stop, those of
    /// this ray's number in [0, 1), and where these are asked, voxels are hit (cover_run.hpp). Null: by all. Of a Tracer
    /// alone.
    const NodeShares* shares = nullptr;
    double number = 0.5;
    bool asks_voxels_of_sheets = false; ///< Of surfaces that fill cubes from side to side voxels are hit, not cubes.
};
struct VoxelHit {
    double distance = std::numeric_limits<double>::infinity(); ///< In lengths of direction; a miss has an infinite one.
    Voxel voxel{}; ///< Or the lowest one of a cube that was not looked into.
    /// The axis across which the ray entered: the normal is that axis, against the direction. 3: it began in the voxel.
    /// In a cube that is partly filled: that of the side which stopped it, within the cube.
    std::uint32_t axis = 3;
    std::uint32_t level = 0; ///< What was hit is 2^level voxels wide.

    bool operator==(const VoxelHit&) const = default;
    [[nodiscard]] bool is_hit() const { return distance < std::numeric_limits<double>::infinity(); }
};

/// A ray that passes through a voxel's inside hits it, at its start where it begins there; one that only touches a
/// corner, an edge or a face does not. Along a face of two voxels, parallel to it, it is in the upper one. Rays that
/// are not finite miss.
[[nodiscard]] VoxelHit trace(const Dag& dag, const VoxelRay& ray);
[[nodiscard]] VoxelHit trace(const PackedDag& dag, const VoxelRay& ray);
/// As many hits as rays; by a Tracer, where they are worth making one. Throws InvalidInput and Cancelled.
void trace(const PackedDag& dag, std::span<const VoxelRay> rays, std::span<VoxelHit> hits, const Progress& progress);
/// Whether each ray hits anything before its end.
void find_occluded(const PackedDag& dag, std::span<const VoxelRay> rays, std::span<bool> are_occluded,
                   const Progress& progress);
} // namespace tyndall::voxel_dag
