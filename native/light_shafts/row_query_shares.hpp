// SPDX-License-Identifier: GPL-3.0-or-later
// How much of each step along a ray is lit, from slope rows: 16 neighbouring light lines are one comparison, and as many
// shadow samples. Few lines are read in whole; of many, evenly spread groups of 16.
// Bound:    per step 1 to 4 comparisons of 16 lines, of few steps more, 256 per ray; a step of up to 64 lines is known to a
//           line, of longer ones these are 4 samples, where shadows change faster than that.
#pragma once
#include "light_shafts/row_query.hpp"
#include "light_shafts/visibility.hpp"

namespace tyndall::light_shafts::row_query {
/// Overwrites the shares of each ray's steps; rays that rows cannot answer are named. The rows' light lines are counted by
/// radius, not by angle.
void find_lit_shares(const slope_rows::Rows& rows, std::span<const ViewRay> rays, const StepRows& steps,
                     std::span<float> shares, Uncovered& uncovered);
} // namespace tyndall::light_shafts::row_query
