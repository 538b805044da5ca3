// SPDX-License-Identifier: GPL-3.0-or-later
// Single view rays, asked for where they lie in transfer functions: what an artist clicked on, what a constraint follows.
#pragma once
#include "render/frame.hpp"
#include "render/ray_parameters.hpp"
#include "render/styled_shafts.hpp"
#include "render/view_path.hpp"

namespace tyndall::render {
/// Parameters in the first of config.transfer_functions of the rays through raster positions of the full frame. Throws
/// InvalidInput without a function, and Cancelled.
[[nodiscard]] std::vector<vec2> ray_parameters(const Scene& scene, const Media& media, const Camera& camera,
                                               const FrameConfig& config, std::span<const vec2> places_px,
                                               Progress& progress);

/// Gives axes of visibility the range that the frame shows, where they ask for it.
void fit_visibility(const ViewPath& path, const light_shafts::Shafts& shafts, const Camera& camera,
                    RayParameters& parameters, const Progress& progress);

/// Where the points that constraints stand for are in each function: those before the camera, each once.
[[nodiscard]] std::vector<PlacedPoint> place_points(const ViewPath& path, const light_shafts::Shafts& shafts,
                                                    const RayParameters& parameters, const Camera& camera,
                                                    std::span<const transfer_functions::WeightedFunction> functions,
                                                    const Progress& progress);
} // namespace tyndall::render
