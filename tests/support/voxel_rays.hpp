// SPDX-License-Identifier: GPL-3.0-or-later
// Rays that tests of tracing voxels share, and what they are to hit.
#pragma once
#include "support/packed_voxels.hpp"
#include "voxel_dag/trace.hpp"
#include <algorithm>
#include <cmath>
#include <random>

namespace tyndall::support {
using voxel_dag::LeafMasks;
using voxel_dag::Voxel;
using voxel_dag::VoxelRay;

/// Where a ray enters a cube, by its lowest voxel; infinite where it does not pass through its inside.
inline double entry_of(const VoxelRay& ray, const Voxel& lowest, double width = 1.0) {
    double from = 0.0, end = ray.end;
    for (int axis = 0; axis < 3; ++axis) {
        const double lower = lowest[static_cast<std::size_t>(axis)], upper = lower + width, origin = ray.origin[axis];
        if (ray.direction[axis] == 0.0) {
            if (origin < lower || origin >= upper)
                return std::numeric_limits<double>::infinity();
            continue;
        }
        const double inverse = 1.0 / ray.direction[axis], a = (lower - origin) * inverse,
                     b = (upper - origin) * inverse;
        from = std::max(from, std::min(a, b));
        end = std::min(end, std::max(a, b));
    }
    return from < end ? from : std::numeric_limits<double>::infinity();
}

/// Random, axis-parallel, through corners and along faces, from inside and from far away; by turns.
inline std::vector<VoxelRay> assorted_rays(const std::vector<Voxel>& voxels, double width, int count) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    std::vector<VoxelRay> rays;
    const auto whole = [&](double from, double to) {
        return std::floor(from + (to - from) * std::abs(uniform(random)));
    };
    for (int i = 0; i < count; ++i) {
        VoxelRay ray{.origin = dvec3(uniform(random), uniform(random), uniform(random)) * width + 0.5 * width,
                     .direction = {uniform(random), uniform(random), uniform(random)}};
        const Voxel& target = voxels[random() % voxels.size()];
        const dvec3 corner(target[0] + (random() & 1), target[1] + (random() & 1), target[2] + (random() & 1));
        switch (i % 8) {
        case 0: // at a corner
            ray.direction = corner - ray.origin;
            break;
        case 1: // along the cube's diagonals, corner by corner
            ray.direction = {random() % 2 ? 1 : -1, random() % 2 ? 1 : -1, random() % 2 ? 1 : -1};
            ray.origin = corner - 7.0 * ray.direction;
            break;
        case 2: // parallel to an axis, along edges
            ray.direction = dvec3(0.0);
            ray.direction[static_cast<int>(random() % 3)] = random() % 2 ? 1.0 : -2.5;
            ray.origin = corner - 9.0 * ray.direction;
            break;
        case 3: // parallel to a plane of faces, within it
            ray.direction[static_cast<int>(random() % 3)] = 0.0;
            ray.origin = corner;
            break;
        case 4: // from inside a voxel
            ray.origin = dvec3(target[0], target[1], target[2]) + 0.5;
            break;
        case 5: // grazing: nearly along a face
            ray.origin = corner;
            ray.direction = {whole(-3, 3), 1e-13 * uniform(random), whole(-3, 3)};
            break;
        case 6: // between whole points
            ray.origin = {whole(0, width), whole(-3, width), whole(0, width)};
            ray.direction = {whole(-4, 4), whole(-4, 4), whole(-4, 4)};
            break;
        default: // with an end
            ray.end = 2.0 * std::abs(uniform(random));
        }
        rays.push_back(ray);
    }
    return rays;
}

/// Those, with all levels of detail and cones from narrow to wide among them.
inline std::vector<VoxelRay> rays_of_detail(const std::vector<Voxel>& voxels, std::uint32_t level, int count) {
    std::vector<VoxelRay> rays = assorted_rays(voxels, static_cast<double>(1u << level), count);
    for (std::size_t i = 0; i < rays.size(); ++i)
        if (i / 8 % 3 == 0)
            rays[i].width = static_cast<double>(1u << i / 24 % level);
        else if (i / 8 % 3 == 1)
            rays[i].spread = 0.2 * static_cast<double>(i % 19);
    return rays;
}
} // namespace tyndall::support
