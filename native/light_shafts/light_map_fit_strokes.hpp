// SPDX-License-Identifier: GPL-3.0-or-later
// From a picture of strokes, painted over what a camera shows, to the rays whose light is to look like them.
// Bound:    a camera ray to the first surface per stroke pixel; a surface that lets light pass counts as the first, too.
#pragma once
#include "light_shafts/light_map_fit.hpp"
#include <string>

namespace tyndall::light_shafts {
/// A picture over a camera's full frame, of any size.
struct StrokePicture {
    std::string name;
    std::uint32_t width = 0, height = 0;
    std::vector<vec4> texels; ///< Rows bottom to top; scene-linear, not multiplied with alpha. Alpha 0: not painted.
};
/// A picture coarser than the frame has a ray for each of the frame's pixels: rays far apart would pass by texels of the
/// map. Where more pixels are painted than `most_pixels`, squares of neighbours are taken together: their mean colour, their
/// summed alpha, the ray of one of them. Pixels that are not finite count as not painted. Throws InvalidInput, Cancelled.
[[nodiscard]] Strokes find_strokes(const Scene& scene, const Camera& camera, const StrokePicture& picture,
                                   std::size_t most_pixels, const Progress& progress);
} // namespace tyndall::light_shafts
