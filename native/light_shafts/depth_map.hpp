// SPDX-License-Identifier: GPL-3.0-or-later
// Depth map of a light: per texel the occluder that is nearest to the light. A sun has one parallel map; a local light
// has perspective faces, one for a narrow spot, up to six of a cube else.
// Rastered by the kernel of slope rows: a row of texels is a parallel slice, the depth is its slope. In a face the
// coordinates are x/z, y/z and 1/z, in which planes stay planes.
// Bound:    4 bytes per texel; one cut per triangle and row of texels.
#pragma once
#include "light_shafts/slope_rows_partial.hpp"
#include "light_shafts/slope_rows_raster.hpp"

namespace tyndall::light_shafts {
/// Where a map lies.
struct MapAxes {
    vec3 origin{0.0f}, x_axis{1, 0, 0}, y_axis{0, 1, 0}, z_axis{0, 0, 1}; ///< z: towards a sun; it leaves a lamp.

    [[nodiscard]] vec3 axes_of(const vec3& v) const {
        return {glm::dot(x_axis, v), glm::dot(y_axis, v), glm::dot(z_axis, v)};
    }
};

/// Texels are Rows of a parallel layout: slice = y, line = x, slope = depth towards the light.
struct DepthMap : MapAxes {
    bool is_perspective = false;
    std::unique_ptr<slope_rows::Rows> texels;

    /// Largest depth at the texel that holds (x, y); no_occluder outside. Parallel: metres along z; perspective: 1/z.
    [[nodiscard]] float depth_at(float x, float y) const {
        const slope_rows::Layout& layout = texels->layout;
        const float column = (x - layout.first_line) / layout.line_step;
        const float row = (y - layout.first_slice) / layout.slice_step + 0.5f;
        if (!(column >= 0.0f && row >= 0.0f && column < static_cast<float>(layout.line_count) &&
              row < static_cast<float>(layout.slice_count())))
            return slope_rows::no_occluder;
        return texels->row(static_cast<std::int32_t>(row)).slopes[static_cast<std::int32_t>(column)];
    }
};

/// The rectangle of a map in its x and y.
struct MapWindow {
    vec2 min, max;
};
/// Rows across a light that shines along parallel lines: u = x, v = y.
[[nodiscard]] slope_rows::Frame frame_across(const MapAxes& axes);
/// Gives the map texels, without values.
void lay_out_texels(DepthMap& map, const MapWindow& window, glm::uvec2 texels);
/// Fills the texels of lay_out_texels. Throws Cancelled.
void raster_depth(DepthMap& map, const MapWindow& window, const Occluders& occluders, const Progress& progress);
/// Adds what lets a part of the light pass to the texels of raster_depth. Throws Cancelled.
void raster_partial_depth(DepthMap& map, const MapWindow& window, const PartialShading& shading,
                          const Progress& progress);
} // namespace tyndall::light_shafts
