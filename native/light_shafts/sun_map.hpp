// SPDX-License-Identifier: GPL-3.0-or-later
// A sun's depth map for filters: counted in texels of a grid that only their size decides, so that a texel has the same
// bits whatever part of the grid a view asks for. What is kept of one view then serves another.
// Differs:  rastered in units of texels, in which the places of rows are exact. Along a row, lines are counted from a
//           multiple of anchor_texels, because a difference of two floats depends on where it starts.
// Bound:    a map that a moved view asks for beyond what is kept is made an eighth larger on every side.
#pragma once
#include "light_shafts/shadow_map.hpp"

namespace tyndall::light_shafts {
/// Texels [first, end) of the grid.
struct TexelRange {
    glm::ivec2 first, end;
    [[nodiscard]] bool contains(const TexelRange& other) const {
        return glm::all(glm::lessThanEqual(first, other.first)) && glm::all(glm::greaterThanEqual(end, other.end));
    }
};
/// Up to the next quarter of an octave: what follows from a slider, or from a view, seldom changes.
[[nodiscard]] float rounded_up(float value);
/// Width of square texels, rounded_up, so that a window has at most `resolution` on a side, or
/// little more.
[[nodiscard]] float snapped_texel(const MapWindow& window, std::uint32_t resolution);
/// The texels that a window touches; rows are multiples of slope_rows::block_lines. Nothing where floats cannot count them.
[[nodiscard]] std::optional<TexelRange> texels_in(const MapWindow& window, float texel);
/// The map of a range, from what is kept of the occluders, if that has it. Takes `room`, if there is one, before it is
/// filled. Throws InvalidInput where that does not suffice, and Cancelled.
[[nodiscard]] DepthMap raster_sun_map(const MapAxes& axes, float texel, const TexelRange& range,
                                      const Occluders& occluders, const PartialShading& partial,
                                      const Progress& progress, const std::shared_ptr<MemoryRoom>& room = {});
} // namespace tyndall::light_shafts
