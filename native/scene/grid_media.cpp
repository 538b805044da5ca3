// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/grid_media.hpp"
#include "scene/scene.hpp"

namespace tyndall {
GridMedia::GridMedia(const SceneDescription& description) {
    for (const VolumeInstance& volume : description.volumes) {
        const Medium& medium = description.media[volume.medium_index];
        PlacedGrid placed{.grid = volume.grid.get(),
                          .medium = static_cast<std::uint16_t>(volume.medium_index),
                          .density_scale = volume.density_scale,
                          .sigma_t_per_m = volume.density_scale * medium.sigma_t_per_m(),
                          .emission_w_per_m3_sr = volume.density_scale * medium.emission_w_per_m3_sr,
                          .bounds = {},
                          .voxel_m = 0.0f};
        if (volume.grid->is_empty() || (placed.sigma_t_per_m == Rgb(0.0f) && placed.emission_w_per_m3_sr == Rgb(0.0f)))
            continue;
        const glm::dmat4 world_from_grid = glm::dmat4(volume.world_from_local) * volume.grid->local_from_grid();
        placed.grid_from_world = glm::inverse(world_from_grid);
        placed.voxel_m = static_cast<float>(std::cbrt(std::abs(glm::determinant(glm::dmat3(world_from_grid)))));
        const Bounds3& box = volume.grid->bounds();
        for (std::size_t corner = 0; corner < 8; ++corner)
            placed.bounds.grow(vec3(glm::dvec3(world_from_grid * glm::dvec4(box.corner(corner), 1.0))));
        grids_.push_back(placed);
        least_voxel_m_ = std::min(least_voxel_m_, placed.voxel_m);
    }
}

Rgb GridMedia::optical_depth(const Ray& ray) const {
    constexpr float opaque = 21.0f; // exp(-21) is 8e-10
    Rgb depth(0.0f);
    for (const PlacedGrid& placed : grids_) {
        const float least = std::min({placed.sigma_t_per_m.x, placed.sigma_t_per_m.y, placed.sigma_t_per_m.z});
        double integral = 0.0;
        for_each_cell(*placed.grid, placed.line(ray.origin, ray.direction), ray.near_m, ray.far_m,
                      [&](const CellSpan& span) {
                          integral += span.integral(span.near_m, span.far_m);
                          return least * static_cast<float>(integral) < opaque;
                      });
        depth += static_cast<float>(integral) * placed.sigma_t_per_m;
    }
    return depth;
}

void GridMedia::append_dense_parts(const Ray& ray, std::vector<LinePart>& parts) const {
    for (const PlacedGrid& placed : grids_) {
        LinePart part{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
        for_each_brick(*placed.grid, placed.line(ray.origin, ray.direction), ray.near_m, ray.far_m,
                       [&](const DensityGrid::Brick&, double near_m, double far_m, const glm::ivec3&) {
                           part.near_m = std::min(part.near_m, near_m);
                           part.far_m = far_m;
                           return true;
                       });
        if (part.near_m < part.far_m)
            parts.push_back(part);
    }
}
} // namespace tyndall
