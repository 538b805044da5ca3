// SPDX-License-Identifier: GPL-3.0-or-later
// Rays that benchmarks of tracing voxels share, in voxels.
#pragma once
#include "voxel_dag/leaf_masks.hpp"
#include "voxel_dag/trace.hpp"
#include <random>
#include <vector>

namespace tyndall::bench {
using voxel_dag::leaf_level;
using voxel_dag::LeafMasks;
using voxel_dag::Voxel;
using voxel_dag::voxel_at;
using voxel_dag::VoxelRay;

/// 1024 x 1024 of a camera.
inline std::vector<VoxelRay> primary_rays(const LeafMasks& voxels) {
    // From in front and a little above, at the middle of the bricks' box, 1.2 of the cube's width away.
    dvec3 lowest(1e9), highest(0.0);
    for (const std::uint64_t code : voxels.codes) {
        const Voxel brick = voxel_at(code << 3 * leaf_level);
        lowest = glm::min(lowest, dvec3(brick[0], brick[1], brick[2]));
        highest = glm::max(highest, dvec3(brick[0], brick[1], brick[2]));
    }
    const dvec3 middle = 0.5 * (lowest + highest), forward = glm::normalize(dvec3(-0.4, -0.3, -1.0));
    const dvec3 right = glm::normalize(glm::cross(forward, dvec3(0, 1, 0))), up = glm::cross(right, forward);
    const dvec3 camera = middle - 1.2 * static_cast<double>(voxels.resolution()) * forward;
    std::vector<VoxelRay> rays;
    for (int y = 0; y < 1024; ++y)
        for (int x = 0; x < 1024; ++x)
            rays.push_back(
                {.origin = camera,
                 .direction = forward + 0.9 * ((x + 0.5) / 1024 - 0.5) * right + 0.9 * ((y + 0.5) / 1024 - 0.5) * up});
    return rays;
}

/// 2^19 from points on a sphere around, aimed at voxels' bricks.
inline std::vector<VoxelRay> random_rays(const LeafMasks& voxels) {
    std::mt19937_64 random(2);
    std::normal_distribution<double> normal;
    const double width = static_cast<double>(voxels.resolution());
    std::vector<VoxelRay> rays;
    for (int i = 0; i < 1 << 19; ++i) {
        const Voxel at = voxel_at(voxels.codes[random() % voxels.codes.size()] << 3 * leaf_level);
        const dvec3 target = dvec3(at[0], at[1], at[2]) + 2.0;
        const dvec3 origin =
            0.5 * width + width * glm::normalize(dvec3(normal(random), normal(random), normal(random)));
        rays.push_back({.origin = origin, .direction = target - origin});
    }
    return rays;
}
} // namespace tyndall::bench
