// SPDX-License-Identifier: GPL-3.0-or-later
// Single scattering fused into the query of slope rows, for a sun: where the optical depth is linear along a piece of a
// view ray, the light that a lit line sends to the camera is a geometric series in the line's number. A masked sum of
// its terms over the lit lines replaces the list of lit intervals and their exponentials.
// Based on: Kol, dissertation, TU Delft 2018, section 5.3, eq. 5.1, in closed form per line.
// Bound:    rays that share a row are asked side by side (row_query_packet-inl.hpp), where there are few, one by one with
//           lines side by side (row_query_alone-inl.hpp), which takes twice as long in the forest at 2,048 lines.
#pragma once
#include "light_shafts/row_query.hpp"

namespace tyndall::light_shafts::row_query {
/// As Visibility::add_scattered. Rays that rows cannot answer, and rays with a piece so dense that a term of the series
/// would overflow (`steep`), get nothing and are named.
struct Unanswered : Uncovered {
    std::vector<std::uint32_t> steep;
};
/// The rows' light lines are counted by radius, not by angle.
void add_scattered(const slope_rows::Rows& rows, std::span<const ViewRay> rays, const PieceRows& pieces,
                   std::span<Rgb> radiance, std::span<float> lit_length_m, Unanswered& unanswered);
} // namespace tyndall::light_shafts::row_query
