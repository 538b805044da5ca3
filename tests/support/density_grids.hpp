// SPDX-License-Identifier: GPL-3.0-or-later
// Density grids for tests, from a function of the voxel's index.
#pragma once
#include "volume/density_grid.hpp"
#include <cmath>
#include <functional>
#include <memory>

namespace tyndall::support {
using DensityOfVoxel = std::function<float(int, int, int)>;

/// Voxels [0, size)^3, in all leaves that hold any of them; `size` a multiple of 8.
inline GridLeaves leaves_of(int size, const DensityOfVoxel& density, const glm::dmat4& local_from_index) {
    GridLeaves leaves{.name = "density", .local_from_index = local_from_index};
    for (int x = 0; x < size; x += 8)
        for (int y = 0; y < size; y += 8)
            for (int z = 0; z < size; z += 8) {
                leaves.origins.emplace_back(x, y, z);
                for (int i = 0; i < 512; ++i)
                    leaves.values.push_back(density(x + i / 64, y + i / 8 % 8, z + i % 8));
            }
    return leaves;
}
/// [-1, 1]^3 by the centres of the outer voxels.
inline glm::dmat4 unit_from_index(int size) {
    return glm::scale(glm::translate(glm::dmat4(1.0), glm::dvec3(-1.0)), glm::dvec3(2.0 / (size - 1)));
}
/// The same, fitted to that.
inline std::shared_ptr<const DensityGrid> unit_grid(int size, const DensityOfVoxel& density) {
    return std::make_shared<const DensityGrid>(leaves_of(size, density, unit_from_index(size)), Progress());
}
/// A lumpy ball of radius 1 in [-1, 1]^3, empty outside.
inline float blob(int size, int x, int y, int z) {
    const vec3 place = vec3(x, y, z) * (2.0f / static_cast<float>(size - 1)) - 1.0f;
    const float lumps =
        1.0f + 0.6f * std::sin(9.0f * place.x + 1.0f) * std::sin(7.0f * place.y) * std::cos(8.0f * place.z + 0.5f);
    return std::max(0.0f, 1.0f - glm::dot(place, place)) * lumps;
}
} // namespace tyndall::support
