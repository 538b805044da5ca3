// SPDX-License-Identifier: GPL-3.0-or-later
// What palettes are made of: the different colours of an attribute array, how often each comes, and what stands for it.
#pragma once
#include "voxel_dag/color_palette.hpp"

namespace tyndall::voxel_dag::color_palette {
struct Originals {
    std::vector<PackedColor> colors;   ///< Different ones, ascending.
    std::vector<std::uint64_t> counts; ///< Entries of each colour.
    std::vector<Cie94From> from;       ///< Differences from each.

    explicit Originals(CountedColors counted);
};
/// The different colours of entries, and which of them each has.
struct CountedEntries {
    CountedColors colors;
    std::vector<std::uint32_t> indices;
};
/// Throws InvalidInput, which names the first entry beyond 24 bits, and Cancelled.
[[nodiscard]] CountedEntries counted(std::span<const PackedColor> entries, const Progress& progress);
/// What is made of colours, of the entries that have them.
[[nodiscard]] Result of_entries(Result of_colors, std::vector<std::uint32_t> indices);

/// center_of holds, per original, the original that stands for it. Moves each such one to the mean of its originals where
/// that helps them on average and leaves none further away than `most_difference`. Indices are those of originals.
[[nodiscard]] Result palette_of(const Originals& originals, const std::vector<std::uint32_t>& center_of,
                                double most_difference, const Progress& progress);
} // namespace tyndall::voxel_dag::color_palette
