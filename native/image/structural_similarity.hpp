// SPDX-License-Identifier: GPL-3.0-or-later
// How alike two pictures look: the structural similarity index (SSIM).
// Based on: Wang, Bovik, Sheikh, Simoncelli, Image Quality Assessment: From Error Visibility to Structural Similarity, TIP
//           13(4), 2004: windows of 11 x 11 pixels, a Gaussian of 1.5 pixels; K_1 = 0.01, K_2 = 0.03; their mean.
// Bound:    separable, 2 x 11 products for each of five sums per pixel, in double precision.
#pragma once
#include "core/progress.hpp"
#include <cstddef>
#include <span>
#include <vector>

namespace tyndall {
struct GreyPicture {
    std::size_t width_px = 0, height_px = 0;
    std::vector<float> values; ///< As displays get them, not linear: 0 to the range.
};
/// The picture's luma, 0 to 255, of linear colours, three or four channels per pixel: each as sRGB encodes it, rounded to
/// a byte and clipped, then 0.299 R + 0.587 G + 0.114 B.
[[nodiscard]] GreyPicture luma_of(std::span<const float> linear, std::size_t channel_count, std::size_t width_px);

/// In [-1, 1], 1 where both are equal; the mean over all windows that lie within the pictures. Throws InvalidInput where
/// they differ in size or are smaller than a window, and Cancelled.
[[nodiscard]] double structural_similarity(const GreyPicture& a, const GreyPicture& b, const Progress& progress,
                                           double range = 255.0);
} // namespace tyndall
