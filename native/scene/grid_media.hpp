// SPDX-License-Identifier: GPL-3.0-or-later
// The media that density grids modulate, placed in the scene. They overlap as homogeneous media do: coefficients add.
#pragma once
#include "scene/camera.hpp"
#include "volume/density_walk.hpp"
#include <array>
#include <span>
#include <vector>

namespace tyndall {
struct SceneDescription;

/// What a channel of a placed grid modulates; the first medium, by nothing, where there is none.
struct GridField {
    std::uint16_t medium = 0;                            ///< Into SceneDescription::media.
    float density_scale = 0.0f;                          ///< Of the medium's coefficients; those below have it.
    Rgb sigma_t_per_m{0.0f}, emission_w_per_m3_sr{0.0f}; ///< At a density of 1 in the grid.
};

struct PlacedGrid {
    const DensityGrid* grid;
    std::array<GridField, DensityGrid::most_channels> fields;
    glm::dmat4 grid_from_world{1.0};
    Bounds3 bounds; ///< Of its density, in the scene.
    float voxel_m;  ///< Side of a cube as large as a voxel.

    [[nodiscard]] GridLine line(const vec3& origin, const vec3& direction) const {
        return {glm::dvec3(grid_from_world * glm::dvec4(glm::dvec3(origin), 1.0)),
                glm::dvec3(grid_from_world * glm::dvec4(glm::dvec3(direction), 0.0))};
    }
    /// Those of the grid's channels.
    [[nodiscard]] std::span<const GridField> used_fields() const {
        return std::span(fields).first(grid->channel_count());
    }
    /// Of densities, or of their integrals.
    [[nodiscard]] Rgb sigma_t_per_m(const vec4& densities) const {
        Rgb sum(0.0f);
        for (std::size_t channel = 0; channel < grid->channel_count(); ++channel)
            sum += densities[static_cast<int>(channel)] * fields[channel].sigma_t_per_m;
        return sum;
    }
};

/// Immutable; safe from any thread. The grids of the description must outlive it.
class GridMedia {
public:
    GridMedia() = default;
    /// Those with density and a medium that acts; channels of one grid in one place are one.
    explicit GridMedia(const SceneDescription& description);

    [[nodiscard]] bool is_empty() const { return grids_.empty(); }
    [[nodiscard]] std::span<const PlacedGrid> all() const { return grids_; }
    [[nodiscard]] const GridField& field(std::size_t grid, std::size_t channel) const {
        return grids_[grid].fields[channel];
    }
    [[nodiscard]] float least_voxel_m() const { return least_voxel_m_; }
    /// visit(field, its density) of those that are not 0 at a place.
    template <class Visit>
    void for_each_density(const vec3& place, const Visit& visit) const {
        for (const PlacedGrid& placed : grids_) {
            const vec4 densities = placed.grid->at(vec3(placed.line(place, vec3(0.0f)).origin));
            for (int channel = 0; const GridField& field : placed.used_fields())
                if (const float density = densities[channel++]; density > 0.0f)
                    visit(field, density);
        }
    }
    /// Per channel; exact, but for less than 1e-9 of the light: a ray of which no more is left is not followed further.
    [[nodiscard]] Rgb optical_depth(const Ray& ray) const;
    /// Appends, per grid, from the first to the last brick with density that the ray meets.
    void append_dense_parts(const Ray& ray, std::vector<LinePart>& parts) const;

private:
    std::vector<PlacedGrid> grids_;
    float least_voxel_m_ = std::numeric_limits<float>::infinity();
};
} // namespace tyndall
