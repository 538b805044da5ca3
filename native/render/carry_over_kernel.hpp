// SPDX-License-Identifier: GPL-3.0-or-later
// The vector loop that carries the texture of the air over from the squares of a picture to its pixels, dispatched at run
// time to the best SIMD target. Its bits are those of one pixel after the other.
#pragma once
#include "light_shafts/light_shafts.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall::render {
/// Difference of two rays' ends, relative to the longer one, at which they have nothing in common.
inline constexpr float other_surface = 0.1f;
/// How much a neighbour counts whose ray ends there; not above 0: not at all.
[[nodiscard]] inline float agreement(float far_m, float other_m) {
    if (far_m == other_m) // of two endless rays, too
        return 1.0f;
    return 1.0f - std::abs(far_m - other_m) / (other_surface * std::max(far_m, other_m)); // of one a NaN
}
/// Of neighbours that hardly agree, all together.
inline constexpr float least_neighbour_weight = 1e-3f;

/// Consecutive pixels of a line of the picture between two lines of squares; each has one ray.
struct PixelsBetweenSquares {
    static constexpr std::size_t padding = 16; ///< Numbers that may be read beyond those of a line.
    std::uint32_t x, side;                     ///< Of the first pixel in the frame; of a square, at least 2.
    std::uint32_t first_square, end_square;    ///< Along the line.
    const float *lower_far_m, *upper_far_m;    ///< Of the squares' rays, from first_square on; both lines are there.
    const float *lower_heterogeneity, *upper_heterogeneity;
    float share_y; ///< Of the upper line.
};
/// Overwrites what each pixel's ray is multiplied by, or dark_air where no neighbour knows; 1 where its radiance is 0, unless
/// dark rays are filled. Returns how many have dark_air.
std::size_t carry_over(const PixelsBetweenSquares& pixels, std::span<const light_shafts::ViewRay> rays,
                       std::span<const Rgb> radiance, bool fills_dark, std::span<float> heterogeneity);
} // namespace tyndall::render
