// SPDX-License-Identifier: GPL-3.0-or-later
// The vector loop of add_shared (shared_strata.hpp): pixels side by side, dispatched at run time to the best SIMD target.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

namespace tyndall::light_shafts::shared_strata {
/// What a line of the picture holds of each pixel, one column of numbers after the other.
enum Column : std::size_t {
    near_m,
    far_m,
    opacity, ///< 0: nothing is like it.
    radiance,
    visibility = radiance + 3,
    patterned,
    unshadowed = patterned + 3,
    column_count = unshadowed + 3,
};
/// Pixels beyond both ends of a line, of opacity 0.
inline constexpr std::size_t line_padding = 16;
/// Two numbers that are as far apart as this share of the smaller one are still alike.
inline constexpr float alike_tolerance = 0.1f;

/// The lines around one, from `reach` below to `reach` above; those beyond the picture are null.
struct LinesAround {
    static constexpr std::size_t most_reach = 2;
    std::array<const float*, 2 * most_reach + 1> lines; ///< At their first pixel.
    std::size_t stride;                                 ///< From column to column.
    std::int32_t reach;
    std::size_t width; ///< Pixels.
    bool has_visibility, has_patterned;
};
/// Of a neighbour this far away along one axis: how much its strata count, a tent over one period and a pixel; and how
/// much where a pattern's place is kept.
[[nodiscard]] constexpr float share_at(std::int32_t offset, std::int32_t reach) {
    return offset == reach || offset == -reach ? 0.5f : 1.0f;
}
[[nodiscard]] constexpr float share_here(std::int32_t offset, std::int32_t reach) {
    const float away = static_cast<float>(offset < 0 ? -offset : offset) / static_cast<float>(reach < 1 ? 1 : reach);
    return away < 1.0f ? 1.0f - away : 0.0f;
}
/// Overwrites the three columns of light and that of visibility with what each pixel of the middle line gets, 0 where its
/// opacity is 0. `out` has the lines' stride, and room for line_padding numbers beyond the width.
void add_line(const LinesAround& around, float* light, float* visibility);
} // namespace tyndall::light_shafts::shared_strata
