// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/snapped_mesh.hpp"
#include "core/parallel.hpp"
#include <atomic>
#include <bit>
#include <cmath>

namespace tyndall::voxel_dag {
static constexpr std::size_t vertices_per_block = 1 << 14;

static std::uint32_t level_of(std::uint32_t resolution) {
    constexpr std::uint32_t least = 1u << leaf_level, most = 1u << most_level;
    require(std::has_single_bit(resolution) && least <= resolution && resolution <= most, "resolution is ", resolution,
            "; powers of two from ", least, " to ", most, " are possible");
    return static_cast<std::uint32_t>(std::countr_zero(resolution));
}

/// The least index that is_wrong(), of `count`; none: count. The same one for any number of threads.
template <typename IsWrong>
static std::size_t first_wrong(std::size_t count, const Progress& progress, const IsWrong& is_wrong) {
    std::atomic<std::size_t> first = count;
    parallel_blocks(count, vertices_per_block, progress, [&](std::size_t begin, std::size_t end) {
        for (std::size_t index = begin; index < end; ++index)
            if (is_wrong(index)) {
                std::size_t least = first.load();
                while (index < least && !first.compare_exchange_weak(least, index))
                    ;
                return;
            }
    });
    return first;
}

template <typename Position>
static void require_usable(std::span<const Position> positions_m, std::span<const uvec3> triangles,
                           const Progress& progress) {
    require(!triangles.empty(), "the mesh has no triangles");
    const std::size_t vertex = first_wrong(positions_m.size(), progress, [&](std::size_t index) {
        const Position& at = positions_m[index];
        return !(std::isfinite(at.x) && std::isfinite(at.y) && std::isfinite(at.z));
    });
    if (vertex < positions_m.size())
        refuse("vertex ", vertex, " lies at (", positions_m[vertex].x, ", ", positions_m[vertex].y, ", ",
               positions_m[vertex].z, ") m");
    const std::size_t triangle = first_wrong(triangles.size(), progress, [&](std::size_t index) {
        return glm::any(glm::greaterThanEqual(
            triangles[index], uvec3(static_cast<std::uint32_t>(std::min<std::size_t>(positions_m.size(), ~0u)))));
    });
    if (triangle < triangles.size())
        refuse("triangle ", triangle, " has the vertices ", triangles[triangle].x, ", ", triangles[triangle].y, ", ",
               triangles[triangle].z, "; there are ", positions_m.size());
}

template <typename Position>
Cube cube_around(std::span<const Position> positions_m, std::span<const uvec3> triangles) {
    dvec3 lower(positions_m[triangles[0].x]), upper = lower;
    for (const uvec3& corners : triangles)
        for (int corner = 0; corner < 3; ++corner) {
            const dvec3 at(positions_m[corners[corner]]);
            lower = glm::min(lower, at);
            upper = glm::max(upper, at);
        }
    const dvec3 extent = upper - lower;
    const double side_m = std::max({extent.x, extent.y, extent.z});
    require(side_m > 0, "all triangles lie in one point: bounds_m has to say which cube is meant");
    return {.lower_m = lower, .side_m = side_m};
}

template Cube cube_around(std::span<const vec3>, std::span<const uvec3>);
template Cube cube_around(std::span<const dvec3>, std::span<const uvec3>);

template <typename Position>
SnappedMesh snap(std::span<const Position> positions_m, std::span<const uvec3> triangles, const VoxelizeConfig& config,
                 const Progress& progress) {
    const std::uint32_t level = level_of(config.resolution);
    require_usable(positions_m, triangles, progress);
    const Cube cube = config.bounds_m ? *config.bounds_m : cube_around(positions_m, triangles);
    require(std::isfinite(cube.lower_m.x) && std::isfinite(cube.lower_m.y) && std::isfinite(cube.lower_m.z) &&
                std::isfinite(cube.side_m) && cube.side_m > 0,
            "bounds_m is a cube at (", cube.lower_m.x, ", ", cube.lower_m.y, ", ", cube.lower_m.z, ") m, ", cube.side_m,
            " m a side");
    const double steps_per_m = static_cast<double>(config.resolution) * (1 << step_bits) / cube.side_m;
    require(std::isfinite(steps_per_m), "bounds_m is a cube of ", cube.side_m, " m a side, too small to divide");
    SnappedMesh mesh{.level = level, .positions = std::vector<Steps>(positions_m.size()), .triangles = triangles};
    const std::int64_t cube_steps = std::int64_t{config.resolution} << step_bits;
    const std::size_t far = first_wrong(positions_m.size(), progress, [&](std::size_t index) {
        const dvec3 at = (dvec3(positions_m[index]) - cube.lower_m) * steps_per_m;
        for (int axis = 0; axis < 3; ++axis) {
            const double steps = std::floor(at[axis] + 0.5);
            if (!(std::abs(steps) < most_steps))
                return true;
            // The upper faces belong to the cube, as if they lay a step within.
            const auto whole = static_cast<std::int64_t>(steps);
            mesh.positions[index][static_cast<std::size_t>(axis)] = whole == cube_steps ? whole - 1 : whole;
        }
        return false;
    });
    if (far < positions_m.size())
        refuse("vertex ", far, " at (", positions_m[far].x, ", ", positions_m[far].y, ", ", positions_m[far].z,
               ") m lies 2^32 voxels or more from the cube of ", cube.side_m, " m at (", cube.lower_m.x, ", ",
               cube.lower_m.y, ", ", cube.lower_m.z, ") m");
    return mesh;
}
template SnappedMesh snap(std::span<const vec3>, std::span<const uvec3>, const VoxelizeConfig&, const Progress&);
template SnappedMesh snap(std::span<const dvec3>, std::span<const uvec3>, const VoxelizeConfig&, const Progress&);
} // namespace tyndall::voxel_dag
