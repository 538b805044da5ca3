// SPDX-License-Identifier: GPL-3.0-or-later
// Epipolar raster: triangles straight into slope rows, without a shadow map. Each triangle is cut by the slices that it
// spans, and the cut, a segment that is straight in X and Y, is kept where it is the highest.
// Based on: Kol, dissertation, TU Delft 2018, section 5.3, whose shadow map and rectification this replaces.
// Differs:  one error instead of two: no texel of a map is looked up from a slice between texels.
// Bound:    40 bytes per triangle and band of 32 slices that it may touch; one cut per triangle and slice. Bands belong
//           to one thread each and a maximum has no order, so the bits do not depend on the number of threads.
#pragma once
#include "light_shafts/occluders.hpp"
#include "light_shafts/slope_rows_kernels.hpp"
#include <functional>

namespace tyndall::light_shafts::slope_rows {
/// The triangles that can touch each band, ready to be cut.
struct BandTriangles {
    std::vector<FramedTriangle> triangles;
    std::vector<std::size_t> first; ///< Band b owns triangles[first[b] .. first[b + 1]).
    [[nodiscard]] std::span<const FramedTriangle> band(std::size_t b) const {
        return std::span(triangles).subspan(first[b], first[b + 1] - first[b]);
    }
};
/// Puts triangles of the piece, from `start` on, into the layout's coordinates; advances `start` past those it has done
/// and returns how many it has placed.
using Placer = std::function<std::size_t(const OccluderPiece& piece, std::size_t& start, PlacedTriangles& placed)>;
/// Throws Cancelled. Without a placer: as the layout's frame places them.
[[nodiscard]] BandTriangles bin_triangles(const Layout& layout, const Occluders& occluders, const Progress& progress,
                                          const Placer& placer = {});

/// Fills all rows. Throws Cancelled.
void raster(Rows& rows, const BandTriangles& triangles, const Progress& progress);
} // namespace tyndall::light_shafts::slope_rows
