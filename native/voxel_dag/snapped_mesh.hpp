// SPDX-License-Identifier: GPL-3.0-or-later
// A mesh whose vertices are integers: steps of 1/256 voxel from the lower corner of the cube.
#pragma once
#include "voxel_dag/voxelize.hpp"
#include <array>
#include <vector>

namespace tyndall::voxel_dag {
inline constexpr int step_bits = 8; ///< A voxel is 2^8 steps wide.
using Steps = std::array<std::int64_t, 3>;
using SnappedTriangle = std::array<Steps, 3>;
/// A vertex lies nearer than this to the cube's lower corner, on each axis: products of three such fit 128 bits.
inline constexpr double most_steps = 1ull << 40;

struct SnappedMesh {
    std::uint32_t level; ///< 2^level voxels a side.
    std::vector<Steps> positions;
    std::span<const uvec3> triangles;
    [[nodiscard]] SnappedTriangle triangle(std::size_t index) const {
        const uvec3& corners = triangles[index];
        return {positions[corners.x], positions[corners.y], positions[corners.z]};
    }
};
/// What is voxelized unless the configuration says: around the vertices that triangles use, which are there and finite.
template <typename Position>
[[nodiscard]] Cube cube_around(std::span<const Position> positions_m, std::span<const uvec3> triangles);
extern template Cube cube_around(std::span<const vec3>, std::span<const uvec3>);
extern template Cube cube_around(std::span<const dvec3>, std::span<const uvec3>);
/// Throws as voxelize() does.
template <typename Position>
[[nodiscard]] SnappedMesh snap(std::span<const Position> positions_m, std::span<const uvec3> triangles,
                               const VoxelizeConfig& config, const Progress& progress);
extern template SnappedMesh snap(std::span<const vec3>, std::span<const uvec3>, const VoxelizeConfig&, const Progress&);
extern template SnappedMesh snap(std::span<const dvec3>, std::span<const uvec3>, const VoxelizeConfig&,
                                 const Progress&);

/// The voxels of a mesh that is snapped already; of the configuration, the rule and the budget count. Throws as voxelize()
/// does.
[[nodiscard]] VoxelizeResult voxelize(const SnappedMesh& mesh, const VoxelizeConfig& config, const Progress& progress);
} // namespace tyndall::voxel_dag
