// SPDX-License-Identifier: GPL-3.0-or-later
// What of a ray's light and of its texture lies in lit parts, from coarse slope rows and columns of air, for rays that share
// a row side by side.
#pragma once
#include "light_shafts/air_columns.hpp"
#include "light_shafts/coarse_rows.hpp"
#include "light_shafts/row_query.hpp"

namespace tyndall::light_shafts::row_query {
inline constexpr std::int32_t most_air_lines = 1280; ///< Of rows that are asked.

/// Sums over lit parts of rays; textured / light is what a ray's light is to be multiplied by.
struct AirSums {
    std::span<float> light, textured;
};
/// Adds `weight` times what each ray has of a light of `air`; rays that rows cannot answer get nothing and are named.
void add_lit_air(const CoarseRows& rows, AirColumns& air, std::size_t light, float weight,
                 std::span<const ViewRay> rays, const AirSums& sums, Uncovered& uncovered);
} // namespace tyndall::light_shafts::row_query
