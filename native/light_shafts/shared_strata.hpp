// SPDX-License-Identifier: GPL-3.0-or-later
// Strata of lights with a size, shared by neighbouring pixels: while a picture has fewer samples per pixel than a light
// has strata, the pixels of a small square ask for different ones, and each takes in what its neighbours have found.
// Based on: Keller and Heidrich, Interleaved Sampling, Rendering Workshop 2001; Segovia et al., Non-interleaved Deferred
//           Shading of Interleaved Sample Patterns, Graphics Hardware 2006 (averaging across the pattern).
// Differs:  only lights whose strata outnumber the samples take part, hard shafts stay as sharp as their pixels; a tent
//           over one period and a pixel counts every stratum exactly once; neighbours count where their air lies alike,
//           and in proportion to its opacity: the rim of a cloud stays a rim; of a lamp with a cone or a picture they
//           count by how much of it is in shadow: a beam keeps its edge, to a pixel, unless the lamp's own width
//           spreads it; rays that pass close to a lamp, where its light changes from pixel to pixel, share nothing.
// Bound:    9 or 25 neighbours per ray; a light is asked once per ray instead of once per stratum. Unbiased over the
//           square; its blur of at most two pixels ends when the samples reach the number of strata.
#pragma once
#include "light_shafts/light_shafts.hpp"
#include <cstdint>
#include <span>

namespace tyndall::light_shafts {
/// The cell of a pixel in the square of 4 x 4 that repeats over the picture, [0, 16), by Bayer's order: cell / 4 is the
/// cell in the square of 2 x 2.
[[nodiscard]] constexpr std::uint8_t cell_of_pixel(std::uint32_t x, std::uint32_t y) {
    constexpr auto of_two = [](std::uint32_t a, std::uint32_t b) { return ((a ^ b) & 1u) * 2u + (b & 1u); };
    return static_cast<std::uint8_t>(4 * of_two(x, y) + of_two(x >> 1, y >> 1));
}

/// Of a ray that shares nothing.
inline constexpr std::uint8_t alone_cell = 255;

/// The media along all rays of one pass over a picture, pixel by pixel in rows.
struct PictureRays {
    std::uint32_t width_px, height_px;
    std::span<const std::uint32_t> first_ray; ///< Pixel p owns air[first_ray[p] .. first_ray[p + 1]).
    std::span<const Air> air;                 ///< Per ray.
    std::span<const std::uint8_t> cells;      ///< Per ray.
};
/// Adds to each ray of the rows [first_row, end_row) the mean that its neighbours within `side` pixels have in `shared`
/// (one value per ray, of a pass) in proportion to the opacity of their air, or to what lamps with a cone would send
/// without shadows; without those whose air lies elsewhere or who share nothing.
void add_shared(const PictureRays& picture, std::uint32_t side, std::uint32_t first_row, std::uint32_t end_row,
                const ConstScattered& shared, const Scattered& sum, const Progress& progress);
} // namespace tyndall::light_shafts
