// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/grid_media.hpp"
#include "scene/scene.hpp"

namespace tyndall {
GridMedia::GridMedia(const SceneDescription& description) {
    const VolumeInstance* last = nullptr; // that has the last of grids_
    for (const VolumeInstance& volume : description.volumes) {
        const Medium& medium = description.media[volume.medium_index];
        const GridField field{.medium = static_cast<std::uint16_t>(volume.medium_index),
                              .density_scale = volume.density_scale,
                              .sigma_t_per_m = volume.density_scale * medium.sigma_t_per_m(),
                              .emission_w_per_m3_sr = volume.density_scale * medium.emission_w_per_m3_sr};
        if (volume.grid->is_empty() || (field.sigma_t_per_m == Rgb(0.0f) && field.emission_w_per_m3_sr == Rgb(0.0f)))
            continue;
        if (last != nullptr && last->grid == volume.grid && last->world_from_local == volume.world_from_local &&
            grids_.back().fields[volume.channel].density_scale == 0.0f) {
            grids_.back().fields[volume.channel] = field;
            continue;
        }
        last = &volume;
        PlacedGrid placed{.grid = volume.grid.get(), .fields = {}, .bounds = {}, .voxel_m = 0.0f};
        placed.fields[volume.channel] = field;
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
    for (const PlacedGrid& placed : grids_)
        with_density_type(*placed.grid, [&]<class Density>(const Density&) {
            vec4 least(0.0f); // that each density takes of every channel of light
            for (int channel = 0; const GridField& field : placed.fields)
                least[channel++] = std::min({field.sigma_t_per_m.x, field.sigma_t_per_m.y, field.sigma_t_per_m.z});
            glm::dvec4 integral(0.0);
            for_each_cell<Density>(*placed.grid, placed.line(ray.origin, ray.direction), ray.near_m, ray.far_m,
                                   [&](const CellSpan<Density>& span) {
                                       add_integral(integral, span.integral(span.near_m, span.far_m));
                                       if constexpr (std::is_same_v<Density, float>)
                                           return least.x * static_cast<float>(integral.x) < opaque;
                                       else
                                           return glm::dot(least, vec4(integral)) < opaque;
                                   });
            depth += placed.sigma_t_per_m(vec4(integral));
        });
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
