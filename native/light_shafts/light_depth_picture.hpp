// SPDX-License-Identifier: GPL-3.0-or-later
// A light's depth map as a picture, before and after the edits of its occluders: what an artist looks at to choose sizes.
#pragma once
#include "scene/scene.hpp"
#include <vector>

namespace tyndall::light_shafts {
/// Rows bottom to top. 0: nearest to the light of all that stands before it; 1: farthest; holes are 1, too. A sun's map
/// shows all occluders; a narrow spot's its cone; other lamps show the six faces of a cube, three side by side.
struct LightDepthPicture {
    std::uint32_t width = 0, height = 0;
    std::vector<float> before, after;
};
/// `resolution`: texels along the longer side of a map, [16, 16384]. Of the middle of a light with a size. Edits of rows,
/// which need a camera, do not show. Throws InvalidInput where nothing casts a shadow or the light has no such index, and
/// Cancelled.
[[nodiscard]] LightDepthPicture light_depth_picture(const Scene& scene, std::size_t light, std::uint32_t resolution,
                                                    const Progress& progress);
} // namespace tyndall::light_shafts
