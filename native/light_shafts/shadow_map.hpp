// SPDX-License-Identifier: GPL-3.0-or-later
// Visibility from a light's depth map: the map is rectified to slope rows, nearest texel, and queried as those are.
// Based on: Kol, dissertation, TU Delft 2018, section 5.3; Baran et al. 2010 (epipolar rectification).
// Differs:  rows hold slopes, not depths, so that a view ray is one number; local lights have faces of a cube, and rows
//           run across their seams, so that a query never sees one.
// Error:    first order in the size of a texel, and equal to walking along the texels once the rows are finer than them.
#pragma once
#include "light_shafts/depth_map.hpp"

namespace tyndall::light_shafts {
/// A light's depth maps: one, or the faces of a cube.
struct ShadowMap {
    bool is_cube = false;
    std::vector<DepthMap> faces;
};
/// Maps of `resolution` texels per side that cover what the rows' light lines need; with what lets a part of the light
/// pass, if `partial` says how. Throws Cancelled.
[[nodiscard]] ShadowMap raster_shadow_map(const slope_rows::Layout& layout, const LightSample& light,
                                          std::uint32_t resolution, const Occluders& occluders,
                                          const Progress& progress, const PartialShading* partial = nullptr);
/// Where a sun's map lies; lamps stand where they are.
struct SunPlace {
    MapAxes axes{};
    MapWindow window{};
    std::shared_ptr<MemoryRoom> room = {}; ///< Of the rows; nothing: there is no limit.
};
/// Around what the rows' light lines need, along the given axes.
[[nodiscard]] SunPlace sun_place(const slope_rows::Layout& layout, const vec3& x_axis, const vec3& y_axis);
/// The same for filters: texels are square and stay where they are while the camera moves, and there are more of them, by
/// `margin` on every side: metres of a sun, tangents of a lamp's face. `resolution`: along the longer side, or a little
/// less. Taken from what is kept of the occluders, if that has it.
[[nodiscard]] ShadowMap raster_filter_map(const SunPlace& place, float margin, const LightSample& light,
                                          std::uint32_t resolution, const Occluders& occluders,
                                          const Progress& progress, const PartialShading& partial);
/// Fills the rows: each sample from the texel that its light line falls into. Throws Cancelled.
void rectify(const ShadowMap& map, slope_rows::Rows& rows, const Progress& progress);
/// From the coordinates of a sun's frame to those of its map.
struct RowsOnMap {
    vec3 offset, along_u, along_v; ///< offset.z: a frame's axial zero as the map counts depth.
    RowsOnMap(const slope_rows::Frame& frame, const MapAxes& map);
    [[nodiscard]] vec2 at(const vec2& uv) const { return vec2(offset + uv.x * along_u + uv.y * along_v); }
};
/// The face and its coordinates for a direction that leaves the light; nothing where no face looks.
struct FacePoint {
    const DepthMap* face = nullptr;
    float x = 0.0f, y = 0.0f, z = 0.0f; ///< z is of the given direction.
};
[[nodiscard]] FacePoint face_point(const ShadowMap& map, const vec3& from_light);
} // namespace tyndall::light_shafts
