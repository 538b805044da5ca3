// SPDX-License-Identifier: GPL-3.0-or-later
// The world's light on surfaces, averaged between neighbouring pixels while each of them has few shadow rays: what comes
// in through a window changes little from pixel to pixel, but is found by few rays.
// Based on: Keller and Heidrich, Interleaved Sampling, Rendering Workshop 2001; its discontinuity buffer: Wald, Kollig,
//           Benthin, Keller, Slusallek, Interactive Global Illumination using Fast Ray Tracing, Rendering Workshop 2002.
// Differs:  only for a world of one radiance, whose shadows are as wide as a room; each pixel has its own rays instead of
//           a common pattern, so that what noise is left has none; irradiance is shared, textures stay sharp.
// Bound:    9 or 25 neighbours of 48 bytes per pixel. Unbiased on planes under even light; its blur of at most two
//           pixels ends when a pixel has more than 64 rays of its own.
#pragma once
#include "core/math.hpp"
#include "core/progress.hpp"
#include <cstdint>
#include <span>

namespace tyndall::render {
/// The first surface along a camera ray that the world lights.
struct WorldLit {
    vec3 position{0.0f}, normal{0.0f}; ///< Normal: the shading normal, unit.
    Rgb albedo{0.0f};                  ///< Radiance at the camera per irradiance; 0: no such surface.
    Rgb irradiance{0.0f};              ///< Found by the pixel's own shadow rays, W/m^2.
};

/// Pixels to each side that share, for so many shadow rays of a pixel in all its samples: 2, 1 or 0.
[[nodiscard]] std::uint32_t shared_reach_px(std::uint64_t rays_per_pixel);

/// In much the same plane: corners, steps and leaves share nothing.
[[nodiscard]] bool is_coplanar(const WorldLit& a, const WorldLit& b);

/// What sharing changes in pixel (x, y) of a picture in rows: its albedo times the difference between its neighbours' mean
/// irradiance and its own. Neighbours are surfaces in the same plane.
[[nodiscard]] Rgb shared_light_gain(std::span<const WorldLit> pixels, std::uint32_t width_px, std::uint32_t reach_px,
                                    std::uint32_t x, std::uint32_t y);
} // namespace tyndall::render
