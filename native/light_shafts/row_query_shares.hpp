// SPDX-License-Identifier: GPL-3.0-or-later
// How much of each step along a ray is lit, from slope rows: 16 neighbouring light lines are one comparison, and as many
// shadow samples. Few lines are read in whole; of many, evenly spread groups of 16.
// Bound:    per step 1 to 4 comparisons of 16 lines. A step of n lines is known to 1 / min(n, 64) where a shadow ends in it,
//           exactly elsewhere.
#pragma once
#include "light_shafts/row_query.hpp"
#include "light_shafts/visibility.hpp"

namespace tyndall::light_shafts::row_query {
/// Overwrites the shares of each ray's steps; rays that rows cannot answer are named. The rows' light lines are counted by
/// radius, not by angle.
void find_lit_shares(const slope_rows::Rows& rows, std::span<const ViewRay> rays, const StepRows& steps,
                     std::span<float> shares, Uncovered& uncovered);
} // namespace tyndall::light_shafts::row_query
