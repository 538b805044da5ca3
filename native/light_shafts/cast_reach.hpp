// SPDX-License-Identifier: GPL-3.0-or-later
// Which parts of a scene may show in a light's rows or maps: where others move, these stay as they are.
// Error:    on the safe side: a box that may show need not. One that may not is drawn by no raster, or lies below every view
//           ray, or beside all that the light shines on.
#pragma once
#include "light_shafts/depth_map.hpp"
#include <functional>

namespace tyndall::light_shafts {
/// Whether something in a box of the scene's space may show; empty: whatever it is, it may.
using MayShow = std::function<bool(const Bounds3& box)>;

/// In rows that triangles, or things traced, are drawn into, as rays of the light ask them. `layout` must outlive it.
[[nodiscard]] MayShow in_rows(const slope_rows::Layout& layout, const LightSample& light);
/// In rows that a depth map is rectified to. `texel`: its width, in metres of a sun's map, or per metre from a lamp.
[[nodiscard]] MayShow in_rows_of_map(const slope_rows::Layout& layout, const LightSample& light, float texel);
/// In a map of a sun, whoever asks it.
[[nodiscard]] MayShow in_map(const slope_rows::Layout& layout);
/// In a lamp's face.
[[nodiscard]] MayShow in_face(const DepthMap& face, const MapWindow& window);
} // namespace tyndall::light_shafts
