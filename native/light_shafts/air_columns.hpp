// SPDX-License-Identifier: GPL-3.0-or-later
// The air in front of a camera in columns, some pixels apart: its texture, and what a light would scatter if nothing cast a
// shadow, as sums from the camera on. Rays between them take the mean of the four around.
// Based on: Wronski, Volumetric Fog, SIGGRAPH 2014 (a volume along the view, of a few pixels per cell).
// Differs:  no shadow is in it: shadows stay as sharp as the slope rows, and each ray's own. Sums are exact between steps
//           however long a lit stretch is. A column is made when a ray next to it is lit, as far as that goes.
// Bound:    per column and step one look-up of the texture, and one exponential and 8 bytes per light.
#pragma once
#include "light_shafts/scatter_pieces.hpp"
#include "scene/camera.hpp"
#include "volume/air_texture.hpp"
#include <atomic>
#include <cmath>

namespace tyndall::light_shafts {
/// Where columns of a picture stand, and where along them steps lie.
struct AirGrid {
    CameraKind kind;
    vec3 x, y, depth; ///< Perspective: dot(x, direction) / dot(depth, direction); else of the origin; plus `offset`.
    vec2 per_rad;     ///< Panoramic: x, y and depth are unit axes, of longitude and latitude 0 in the middle.
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
        if (kind == CameraKind::Panoramic) {
            const float right = glm::dot(x, ray.direction), ahead = glm::dot(depth, ray.direction);
            return per_rad * vec2(std::atan2(right, ahead),
                                  std::atan2(glm::dot(y, ray.direction), std::hypot(right, ahead))) +
                   offset;
        }
        if (kind == CameraKind::Orthographic)
            return vec2(glm::dot(x, ray.origin), glm::dot(y, ray.origin)) + offset;
        return vec2(glm::dot(x, ray.direction), glm::dot(y, ray.direction)) / glm::dot(depth, ray.direction) + offset;
    }
    /// How far the ray's own distances lie behind those along columns.
    [[nodiscard]] float shift_m(const ViewRay& ray) const {
        return kind == CameraKind::Orthographic ? glm::dot(depth, ray.origin) - plane_m : 0.0f;
    }
};
/// The camera whose pixels columns stand among: the picture's own, or, of a panorama of another kind, an equirectangular
/// one of all directions with pixels as wide as in the picture's middle.
[[nodiscard]] Camera camera_of_columns(const Camera& camera);
/// Of a camera of columns. Steps as long as those that rays which end halfway would have alone, as far as light of
/// `most_depth` optical depth comes; columns are as far apart at the far end as steps are long, and at least a pixel.
[[nodiscard]] AirGrid make_air_grid(const Media& media, const Camera& camera, const AirTexture& air, float most_depth);

/// Made where and as far as they are asked for. Safe from any thread; the bits depend neither on who asks nor in what order.
class AirColumns {
public:
    /// `offset` in (0, 1): where in a step its point lies. All must outlive this.
    AirColumns(const Media& media, const Camera& camera, const AirGrid& grid, const AirTexture& air, float offset,
               std::vector<const DirectionalScatter*> lights);

    [[nodiscard]] const AirGrid& grid() const { return grid_; }
    /// Makes known the first `count` steps of a column, up to the next multiple of 16.
    void reach(std::size_t column, std::uint32_t count);
    /// Sums up to the far ends of those steps; the next column has its own grid().step_count farther on.
    [[nodiscard]] const float* light(std::size_t of_light, std::size_t column) const {
        return &sums_[of_light].light[column * grid_.step_count];
    }
    [[nodiscard]] const float* textured(std::size_t of_light, std::size_t column) const {
        return &sums_[of_light].textured[column * grid_.step_count];
    }

private:
    struct Sums {
        std::unique_ptr<float[]> light, textured; ///< Column by column.
    };
    void extend(std::size_t column, std::uint32_t begin, std::uint32_t end);
    void add_up(const DirectionalScatter& light, const ViewRay& clipped, std::span<const MediumSegment> segments,
                std::uint32_t begin, std::span<const float> texture, float* light_sums, float* textured_sums) const;
    [[nodiscard]] float step_at(float distance_m) const {
        return std::clamp((distance_m - grid_.first_m) / grid_.step_m, 0.0f, static_cast<float>(grid_.step_count));
    }

    const Media& media_;
    const Camera& camera_;
    const AirGrid& grid_;
    const AirTexture& air_;
    std::vector<const DirectionalScatter*> lights_;
    std::vector<float> at_m_;                       ///< Of the points.
    std::vector<std::atomic<std::uint32_t>> ready_; ///< Steps that are known; and whether more are being made.
    std::vector<Sums> sums_;                        ///< Of each light.
};
} // namespace tyndall::light_shafts
