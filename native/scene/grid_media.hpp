// SPDX-License-Identifier: GPL-3.0-or-later
// The media that density grids modulate, placed in the scene. They overlap as homogeneous media do: coefficients add.
#pragma once
#include "scene/camera.hpp"
#include "volume/density_walk.hpp"
#include <span>
#include <vector>

namespace tyndall {
struct SceneDescription;

struct PlacedGrid {
    const DensityGrid* grid;
    std::uint16_t medium;                    ///< Into SceneDescription::media.
    float density_scale;                     ///< Of the medium's coefficients; those below have it.
    Rgb sigma_t_per_m, emission_w_per_m3_sr; ///< At a density of 1 in the grid.
    glm::dmat4 grid_from_world{1.0};
    Bounds3 bounds; ///< Of its density, in the scene.
    float voxel_m;  ///< Side of a cube as large as a voxel.

    [[nodiscard]] GridLine line(const vec3& origin, const vec3& direction) const {
        return {glm::dvec3(grid_from_world * glm::dvec4(glm::dvec3(origin), 1.0)),
                glm::dvec3(grid_from_world * glm::dvec4(glm::dvec3(direction), 0.0))};
    }
};

/// Immutable; safe from any thread. The grids of the description must outlive it.
class GridMedia {
public:
    GridMedia() = default;
    /// Those with density and a medium that acts.
    explicit GridMedia(const SceneDescription& description);

    [[nodiscard]] bool is_empty() const { return grids_.empty(); }
    [[nodiscard]] std::span<const PlacedGrid> all() const { return grids_; }
    [[nodiscard]] float least_voxel_m() const { return least_voxel_m_; }
    /// Per channel; exact, but for less than 1e-9 of the light: a ray of which no more is left is not followed further.
    [[nodiscard]] Rgb optical_depth(const Ray& ray) const;
    /// Appends, per grid, from the first to the last brick with density that the ray meets.
    void append_dense_parts(const Ray& ray, std::vector<LinePart>& parts) const;

private:
    std::vector<PlacedGrid> grids_;
    float least_voxel_m_ = std::numeric_limits<float>::infinity();
};
} // namespace tyndall
