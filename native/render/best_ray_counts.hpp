// SPDX-License-Identifier: GPL-3.0-or-later
// From the variances and costs of rays: how many shadow rays of each light make a pixel least noisy in a fixed time.
// Based on: Bolin and Meyer, An Error Metric for Monte Carlo Ray Tracing, EGWR 1997:
//           (v_0 + sum v_l / n_l) (c_0 + sum n_l c_l), with the variances v and costs c of a camera ray (0) and of a
//           light's shadow ray, is least at n_l = sqrt((v_l / c_l) / (v_0 / c_0)).
// Differs:  powers of two, for the mean standard error of many pixels. A number below one: the light takes turns, and is
//           asked at every second or fourth sample of a pixel alone.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

namespace tyndall::render {
/// Of the samples of one pixel, relative to the square of its brightness.
struct PixelVariances {
    double of_camera;             ///< Of one camera ray, if its light were known.
    std::vector<double> of_light; ///< Of one shadow ray to each light.
    /// Of one camera ray, if only this light were there and known; empty: nothing.
    std::vector<double> of_camera_by_light = {};
};
/// Times, up to a factor: of a camera ray with its shading and its shafts, and of a shadow ray to each light.
struct RayCosts {
    double of_camera;
    std::vector<double> of_light;
    /// Per light, of the error in a fixed time: what twice its rays must save. Empty: anything.
    std::vector<double> least_savings = {};
};
/// The powers of two up to 16 with the least mean standard error of a pixel in a fixed time.
[[nodiscard]] std::vector<std::uint32_t> best_ray_counts(std::span<const PixelVariances> pixels, const RayCosts& costs);
/// The powers of two up to `longest` with the same for the lights of one ray: what is asked for less often is as much
/// noisier, with all that differs between camera rays. All 1 where that saves little.
[[nodiscard]] std::vector<std::uint32_t> best_turns(std::span<const PixelVariances> pixels, const RayCosts& costs,
                                                    std::span<const std::uint32_t> counts, std::uint32_t longest);
} // namespace tyndall::render
