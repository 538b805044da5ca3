// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes for the tests of voxelize(), in whole steps of 1/256 voxel, so that the oracle sees the very same vertices.
#pragma once
#include "native/voxel_dag/triangle_overlap.hpp"
#include <cmath>
#include <random>

namespace tyndall::voxel_dag::oracle {
struct Mesh {
    std::vector<dvec3> positions;
    std::vector<uvec3> triangles;
};
inline Mesh mesh_of(const std::vector<Triangle>& triangles) {
    Mesh mesh;
    for (const Triangle& triangle : triangles) {
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        for (const Point& corner : triangle)
            mesh.positions.push_back(dvec3(corner[0], corner[1], corner[2]) / double{steps_per_voxel});
        mesh.triangles.emplace_back(first, first + 1, first + 2);
    }
    return mesh;
}
inline VoxelizeConfig config_of(std::uint32_t level, VoxelizeRule rule) {
    return {.resolution = 1u << level, .rule = rule, .bounds_m = Cube{.lower_m = dvec3(0), .side_m = std::exp2(level)}};
}
inline VoxelizeResult voxelized(const std::vector<Triangle>& triangles, std::uint32_t level, VoxelizeRule rule) {
    const Mesh mesh = mesh_of(triangles);
    return voxelize(std::span<const dvec3>(mesh.positions), mesh.triangles, config_of(level, rule), Progress());
}

/// Whole numbers from a generator's own bits: standard distributions differ between libraries.
inline std::int64_t random_below(std::mt19937& random, std::int64_t end) {
    return static_cast<std::int64_t>((std::uint64_t{random()} << 32 | random()) % static_cast<std::uint64_t>(end));
}
/// Corners up to `reach` voxels from a place in the cube or `beyond` voxels around it, at multiples of `grid` steps.
inline Triangle random_triangle(std::mt19937& random, std::uint32_t level, std::int64_t reach, std::int64_t beyond,
                                std::int64_t grid) {
    const std::int64_t side = std::int64_t{1} << level;
    Triangle triangle;
    Point place;
    for (std::int64_t& at : place)
        at = random_below(random, (side + 2 * beyond) * steps_per_voxel) - beyond * steps_per_voxel;
    for (Point& corner : triangle)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::int64_t at =
                place[axis] + random_below(random, (2 * reach + 1) * steps_per_voxel) - reach * steps_per_voxel;
            corner[axis] = at - (at % grid + grid) % grid;
            if (corner[axis] == side * steps_per_voxel)
                corner[axis] -= grid; // what lies on the upper faces is a test of its own
        }
    return triangle;
}

/// Outside faces of a tetrahedron.
inline std::vector<Triangle> tetrahedron(const std::array<Point, 4>& corners) {
    return {{corners[0], corners[1], corners[2]},
            {corners[0], corners[1], corners[3]},
            {corners[0], corners[2], corners[3]},
            {corners[1], corners[2], corners[3]}};
}
/// Two triangles for each side of a box.
inline std::vector<Triangle> box(const Point& lower, const Point& upper) {
    std::vector<Triangle> triangles;
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const bool is_upper : {false, true}) {
            const std::size_t b = (axis + 1) % 3, c = (axis + 2) % 3;
            Point corner = lower;
            corner[axis] = is_upper ? upper[axis] : lower[axis];
            Point along_b = corner, along_c = corner, opposite = corner;
            along_b[b] = opposite[b] = upper[b];
            along_c[c] = opposite[c] = upper[c];
            triangles.push_back({corner, along_b, opposite});
            triangles.push_back({corner, opposite, along_c});
        }
    return triangles;
}
} // namespace tyndall::voxel_dag::oracle
