// SPDX-License-Identifier: GPL-3.0-or-later
// The air in front of a camera in columns, some pixels apart: its texture, and what a light would scatter if nothing cast a
// shadow, as sums from the camera on. Rays between them take the mean of the four around.
// Based on: Wronski, Volumetric Fog, SIGGRAPH 2014 (a volume along the view, of a few pixels per cell).
// Differs:  no shadow is in it: shadows stay as sharp as the slope rows, and each ray's own. Sums are exact between steps
//           however long a lit stretch is. A column ends where the last of the rays around it does.
// Bound:    per column and step one look-up of the texture, and one exponential and 8 bytes per light.
#pragma once
#include "light_shafts/scatter_pieces.hpp"
#include "scene/camera.hpp"
#include "volume/air_texture.hpp"
#include <atomic>

namespace tyndall::light_shafts {
/// Where columns of a picture stand, and where along them steps lie.
struct AirGrid {
    bool is_orthographic;
    vec3 x, y, depth; ///< Perspective: dot(x, direction) / dot(depth, direction); else of the origin; plus `offset`.
    vec2 offset;
    float plane_m;               ///< dot(depth, origin) where distances along orthographic columns are 0.
    std::uint32_t width, height; ///< Columns, at least 2.
    float cell_px;               ///< From column to column.
    float first_m, step_m;       ///< Where steps begin; no step where step_m is 0.
    std::uint32_t step_count;    ///< A multiple of 16.

    [[nodiscard]] bool is_empty() const { return !(step_m > 0.0f); }
    [[nodiscard]] float last_m() const { return first_m + step_m * static_cast<float>(step_count); }
    [[nodiscard]] std::size_t column_count() const { return std::size_t{width} * height; }
    /// Where a ray passes between the columns, in cells.
    [[nodiscard]] vec2 place(const ViewRay& ray) const {
        if (is_orthographic)
            return vec2(glm::dot(x, ray.origin), glm::dot(y, ray.origin)) + offset;
        return vec2(glm::dot(x, ray.direction), glm::dot(y, ray.direction)) / glm::dot(depth, ray.direction) + offset;
    }
    /// How far the ray's own distances lie behind those along columns.
    [[nodiscard]] float shift_m(const ViewRay& ray) const {
        return is_orthographic ? glm::dot(depth, ray.origin) - plane_m : 0.0f;
    }
};
/// Steps as long as those that rays which end halfway would have alone, as far as light of `most_depth` optical depth comes;
/// columns are as far apart at the far end as steps are long, and at least a pixel.
[[nodiscard]] AirGrid make_air_grid(const Media& media, const Camera& camera, const AirTexture& air, float most_depth);

/// Steps that columns must have for the rays between them. The result does not depend on who adds first.
class AirNeeds {
public:
    /// Rays so many cells apart, along each axis, may be asked together: columns last for all of these.
    static constexpr float most_span = 1.75f;

    explicit AirNeeds(const AirGrid& grid) : grid_(grid), steps_(grid.column_count()) {}
    /// Safe from any thread.
    void add(std::span<const ViewRay> rays);
    /// Column by column, multiples of 16; 0 where no ray is near.
    [[nodiscard]] std::vector<std::uint32_t> of_columns() const;

private:
    const AirGrid& grid_;
    std::vector<std::atomic<std::uint32_t>> steps_; ///< Of the cell whose lower left corner is the column.
};

/// Sums up to the far end of each step, column by column.
struct ColumnLight {
    std::unique_ptr<float[]> light, textured;
};

class AirColumns {
public:
    /// `offset` in (0, 1): where in a step its point lies. All must outlive this. Throws Cancelled.
    AirColumns(const Media& media, const Camera& camera, const AirGrid& grid, const AirNeeds& needs,
               const AirTexture& air, float offset, const Progress& progress);

    [[nodiscard]] const AirGrid& grid() const { return grid_; }
    [[nodiscard]] std::uint32_t step_count(std::size_t column) const { return steps_[column]; }
    /// Throws Cancelled.
    [[nodiscard]] ColumnLight find(const DirectionalScatter& light, const Progress& progress) const;

private:
    [[nodiscard]] ViewRay ray(std::size_t column) const;
    void prefer_large(float* values) const;

    const Media& media_;
    const Camera& camera_;
    const AirGrid& grid_;
    std::vector<std::uint32_t> steps_; ///< Per column; what lies behind them is not there.
    std::vector<float> at_m_;          ///< Of the points.
    std::unique_ptr<float[]> texture_; ///< Column by column; 0 outside of media.
};
} // namespace tyndall::light_shafts
