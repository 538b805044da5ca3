// SPDX-License-Identifier: GPL-3.0-or-later
// How fine the steps through density grids and the light columns must be for the error that a frame may have.
// Based on: the errors of some rays, measured against steps of a voxel with exact losses: what a smoke's detail asks for
//           is seen, not estimated from its voxels' size.
// Bound:    64 rays and at most 3 light samples; each candidate is twice as fine, and costs twice to eight times, as the
//           one before. Where columns a quarter of a voxel apart are too coarse, or where 1 GiB would leave more than 10 %
//           of error, light walks through the grid to each point: 10 ns per cell until nothing of it is left.
#pragma once
#include "light_shafts/light_shares.hpp"
#include "light_shafts/prepared_lights.hpp"

namespace tyndall::light_shafts {
struct GridResolution {
    StepLimits step_limits;
    GridLoss loss;
    float step_error = 0.0f, loss_error = 0.0f; ///< Relative RMS, as measured.
};

/// For `rays` that are clipped to the media. Light columns of all beams of `lights` take at most 1 GiB. Leaves the beams
/// as they were, but for their grids' loss. Throws Cancelled.
[[nodiscard]] GridResolution choose_grid_resolution(const Media& media, std::span<const ViewRay> rays,
                                                    std::span<LightBeams> lights, const LightShares& shares,
                                                    const Config& config, const Progress& progress);
} // namespace tyndall::light_shafts
