// SPDX-License-Identifier: GPL-3.0-or-later
// The air in front of a camera in columns, some pixels apart: its texture, and what a light would scatter if nothing cast a
// shadow, as sums from the camera on. Rays between them take the mean of the four around.
// Based on: Wronski, Volumetric Fog, SIGGRAPH 2014 (a volume along the view, of a few pixels per cell).
// Differs:  no shadow is in it: shadows stay as sharp as the slope rows, and each ray's own. Sums are exact between steps
//           however long a lit stretch is. Columns hold no surface: one depth of the picture is as good as another.
// Bound:    per column and step one look-up of the texture and one exponential per light; 8 bytes per light.
#pragma once
#include "light_shafts/scatter_pieces.hpp"
#include "scene/camera.hpp"
#include "volume/air_texture.hpp"

namespace tyndall::light_shafts {
/// Nodes of a picture: where a ray passes between them.
struct PictureGrid {
    bool is_orthographic;
    vec3 x, y, depth; ///< Perspective: dot(x, direction) / dot(depth, direction); else of the origin, plus `offset`.
    vec2 offset;
    float plane_m;               ///< dot(depth, origin) where distances of orthographic columns are 0.
    std::uint32_t width, height; ///< Nodes, at least 2.
};

/// Sums up to the far end of each step, node by node.
struct ColumnLight {
    std::vector<float> light, textured;
};

class AirColumns {
public:
    /// `offset` in (0, 1): where in a step its point lies. Throws Cancelled.
    AirColumns(const Media& media, const Camera& camera, const AirTexture& air, float offset, float most_depth,
               const Progress& progress);

    [[nodiscard]] const PictureGrid& grid() const { return grid_; }
    [[nodiscard]] float first_m() const { return first_m_; }
    [[nodiscard]] float step_m() const { return step_m_; }
    [[nodiscard]] float last_m() const { return first_m_ + step_m_ * static_cast<float>(step_count_); }
    /// A multiple of 16.
    [[nodiscard]] std::uint32_t step_count() const { return step_count_; }
    /// Throws Cancelled.
    [[nodiscard]] ColumnLight find(const DirectionalScatter& light, const Progress& progress) const;
    [[nodiscard]] bool is_empty() const { return !(step_m_ > 0.0f); }

private:
    void find_ends(float most_depth, const Progress& progress);
    [[nodiscard]] ViewRay ray(std::size_t column) const;

    const Media& media_;
    Camera camera_;
    PictureGrid grid_;
    float cell_px_;
    float first_m_ = 0.0f, step_m_ = 0.0f, offset_;
    std::uint32_t step_count_;
    std::vector<float> texture_; ///< Node by node; 0 outside of media.
};
} // namespace tyndall::light_shafts
