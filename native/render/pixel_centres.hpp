// SPDX-License-Identifier: GPL-3.0-or-later
// What lies in the middle of each pixel: depth, position and indices, of which a mean would be that of nothing there is.
// Differs:  from Cycles, whose first sample goes through the centre and brings light home from there, too;
//           here these rays bring nothing else home. The lens does not blur them.
// Bound:    a camera ray a pixel, where a pass asks for them.
#pragma once
#include "render/data_passes.hpp"
#include "render/film.hpp"
#include "render/surface_pass.hpp"

namespace tyndall::render {
struct FrameConfig; // frame.hpp

/// Puts what they find in the film's sums, and in the data's. Throws Cancelled.
void see_pixel_centres(const ViewPath& path, const Camera& camera, const Region& region, const FrameConfig& config,
                       FilmSums& sums, DataSums* data, const Progress& progress);
} // namespace tyndall::render
