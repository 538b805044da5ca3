// SPDX-License-Identifier: GPL-3.0-or-later
// Lit parts of view rays from slope rows: one compare per light line, none where a block of 16 lines is wholly lit or
// dark, and the transitions fall out of mask ^ (mask << 1).
// Based on: Baran et al., A Hierarchical Volumetric Shadow Algorithm, SIGGRAPH 2010 (min-max tree over epipolar rows).
// Differs:  two flat levels with a fan-out of 16, scanned 16 blocks at a time: a tree of pointers or of powers of two
//           loses to the width of a vector.
// Bound:    a view ray reads 2 values per 16 lines, and 16 slopes per block that a shadow's border crosses.
#pragma once
#include "light_shafts/slope_rows.hpp"
#include <span>

namespace tyndall::light_shafts::row_query {
/// Why rays had to be answered by another method.
struct Uncovered {
    std::vector<std::uint32_t> near_epipole; ///< Rays of the call: closer to the epipole than rows resolve.
    std::vector<std::uint32_t> outside;      ///< They reach beyond the rows that were prepared.
};
/// Appends the lit intervals of each ray; a ray that rows cannot answer gets none and is named in `uncovered`.
void lit_intervals(const slope_rows::Rows& rows, std::span<const ViewRay> rays, LitRows& lit, Uncovered& uncovered);

inline constexpr std::uint32_t slices_per_wedge = 32;
/// The rays in the order of wedges, which are groups of consecutive slices; within a wedge some thousand at a time,
/// slice by slice, in the order that they come in. Queried so, a row is read while it is in the cache, and rays, too,
/// are fetched and written in stretches of the picture (one slice after the other, fetching rays takes longer than
/// asking for them). Of coarse rows each stands for several slices. Of the rays `asked`, unless that is empty: all.
/// Throws Cancelled.
[[nodiscard]] std::vector<std::uint32_t> by_wedge(const slope_rows::Layout& layout, std::span<const ViewRay> rays,
                                                  const Progress& progress, std::int32_t slices_per_row = 1,
                                                  std::span<const std::uint32_t> asked = {});

/// Lines [first, last] of one row that are lit for `slope`, as alternating first lit and first dark lines; ends are
/// clipped. The kernel of lit_intervals, for tests.
void lit_runs(const slope_rows::RowView& row, float slope, std::int32_t first, std::int32_t last,
              std::vector<std::int32_t>& borders);
} // namespace tyndall::light_shafts::row_query
