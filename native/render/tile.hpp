// SPDX-License-Identifier: GPL-3.0-or-later
// A tile of a frame whose other tiles are rendered elsewhere: with a margin, for what neighbouring pixels share, that is
// cut off again.
// Bound: a margin of 8 pixels to each side for each round after which pixels may stop, and the camera rays of the full
//        frame's first sample where there are media.
#pragma once
#include "render/frame.hpp"

namespace tyndall::render {
/// The settings that render a tile with all that its pixels look at. Throws InvalidInput that names a setting under which
/// a pixel depends on pixels farther than that.
[[nodiscard]] FrameConfig grown_tile(const FrameConfig& config, const Region& tile, const Camera& camera);
/// The part of a film of `from` that shows `to`, which lies in it; with the film's statistics.
[[nodiscard]] Film cropped(Film film, const Region& from, const Region& to);
} // namespace tyndall::render
