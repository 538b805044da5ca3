// SPDX-License-Identifier: GPL-3.0-or-later
#include "volume/baked_air.hpp"
#include "core/errors.hpp"
#include "core/parallel.hpp"
#include <cmath>

namespace tyndall {
/// A level between two is that mean of both which so many looks in even steps give.
static constexpr std::uint32_t look_count = 4;

std::vector<float> bake_air(const AirTexture& air, const std::array<std::uint32_t, 3>& size, const Progress& progress) {
    const auto [nx, ny, nz] = size;
    require(nx > 0 && ny > 0 && nz > 0, "air is baked into ", nx, " x ", ny, " x ", nz, " voxels");
    const Heterogeneity& heterogeneity = air.heterogeneity();
    const glm::dmat4 scene_from_unit = glm::inverse(glm::dmat4(heterogeneity.unit_from_scene));
    const double box_m3 = std::abs(glm::determinant(glm::dmat3(scene_from_unit)));
    require(std::isfinite(box_m3) && box_m3 > 0.0, "the box that air is baked in has ", box_m3, " cubic metres");
    const double voxel_m = std::cbrt(box_m3 / nx / ny / nz);
    const double texel_m =
        double{AirNoiseVolume::cells_per_side} * double{heterogeneity.noise.scale_m} / heterogeneity.noise.resolution;
    const auto least_level = static_cast<float>(std::max(0.0, std::log2(voxel_m / texel_m)));

    std::vector<float> values(std::size_t{nx} * ny * nz);
    const auto bake_row = [&](std::size_t row) {
        const double y = (static_cast<double>(row % ny) + 0.5) / ny, z = (static_cast<double>(row / ny) + 0.5) / nz;
        for (std::uint32_t x = 0; x < nx; ++x) {
            const vec3 point(scene_from_unit * glm::dvec4((x + 0.5) / nx, y, z, 1.0));
            float sum = 0.0f;
            for (std::uint32_t look = 0; look < look_count; ++look)
                sum += air.at(point, least_level, (static_cast<float>(look) + 0.5f) / float{look_count});
            values[row * nx + x] = sum / float{look_count};
        }
    };
    parallel_for(std::size_t{ny} * nz, progress, bake_row, /*block_size=*/16);
    return values;
}
} // namespace tyndall
