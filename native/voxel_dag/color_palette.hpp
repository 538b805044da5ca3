// SPDX-License-Identifier: GPL-3.0-or-later
// Many colours as few: a palette of a chosen size, or one in which no colour is further from its original than chosen.
// Based on: Xiang, Color Image Quantization by Minimizing the Maximum Intercluster Distance, ACM TOG 16(3), 1997, in
//           CIELAB as Kol 2018, section 2.4.3: the next colour of a palette is the original that is worst off.
// Differs:  CIE94 in place of distances in CIELAB. With a chosen difference, originals join the nearest colour within it,
//           the most frequent first, so that frequent colours stay as they are; without it, that would cost a pass per
//           colour. Then each colour moves to the mean of its originals, if none of them gets worse than the worst was.
// Bound:    size k of n different colours: n k differences, at 2 ns; chosen difference d: n searches of a grid of side d.
//           300 bytes per different colour at most. The same bits for any number of threads, and however the colours were
//           counted. Lossless: material_indices_of().
#pragma once
#include "core/progress.hpp"
#include "voxel_dag/cielab.hpp"
#include <span>
#include <vector>

namespace tyndall::voxel_dag::color_palette {
/// CIE94, over all entries.
struct Statistics {
    double mean_difference = 0.0, most_difference = 0.0;
};
/// The different colours of some entries, and how often each comes.
struct CountedColors {
    std::vector<PackedColor> colors; ///< Ascending.
    std::vector<std::uint64_t> counts;
};
inline constexpr std::uint64_t bytes_per_color = 300; ///< While a palette is made, of each different colour.
struct Result {
    std::vector<PackedColor> colors;    ///< The palette, ascending.
    std::vector<std::uint32_t> indices; ///< Per entry, or per counted colour, below colors.size().
    Statistics statistics;
};
/// At most color_count colours, [1, 65536]. Throws InvalidInput, which names an entry beyond 24 bits, and Cancelled.
[[nodiscard]] Result of_size(std::span<const PackedColor> entries, std::uint32_t color_count, const Progress& progress);
/// Every entry's colour is at most most_difference from it, [0.01, 100]; 1 is hardly seen side by side.
[[nodiscard]] Result within(std::span<const PackedColor> entries, double most_difference, const Progress& progress);
/// The same palettes, of colours of 24 bits that are counted already.
[[nodiscard]] Result counted_of_size(CountedColors colors, std::uint32_t color_count, const Progress& progress);
[[nodiscard]] Result counted_within(CountedColors colors, double most_difference, const Progress& progress);
} // namespace tyndall::voxel_dag::color_palette
