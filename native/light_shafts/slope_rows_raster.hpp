// SPDX-License-Identifier: GPL-3.0-or-later
// Epipolar raster: triangles straight into slope rows, without a shadow map. Each triangle is cut by the slices that it
// spans, and the cut, a segment that is straight in X and Y, is kept where it is the highest.
// Based on: Kol, dissertation, TU Delft 2018, section 5.3, whose shadow map and rectification this replaces.
// Differs:  one error instead of two: no texel of a map is looked up from a slice between texels.
// Bound:    one cut per triangle and slice; nothing is stored but the rows. Triangles are placed once per range of
//           slices that their block overlaps: reading them again is cheaper than sorting them into bands (36 bytes from
//           the cache against 40 to memory and back). Slices belong to one thread each and a maximum has no order, so
//           the bits do not depend on the number of threads.
#pragma once
#include "light_shafts/occluders.hpp"
#include "light_shafts/slope_rows_kernels.hpp"
#include <functional>

namespace tyndall::light_shafts::slope_rows {
/// Appends triangles of the block, from `start` on, that may touch the slices [first, end); returns where to go on.
using Placer =
    std::function<std::size_t(const OccluderInstance& instance, const OccluderBlock& block, std::size_t start,
                              std::int32_t first, std::int32_t end, PlacedTriangles& placed)>;
/// Raises the samples of the slices [first, end) to the shapes that are traced.
using Tracer = std::function<void(std::int32_t first, std::int32_t end)>;
/// How a map of a lamp draws what the layout's frame does not place.
struct MapDrawing {
    vec3 lamp; ///< Where it stands.
    Placer placer;
    Tracer tracer;
};
/// Fills all rows. Throws Cancelled. Nothing: as the layout's frame places triangles and runs lines.
void raster(Rows& rows, const Occluders& occluders, const Progress& progress, const MapDrawing* map = nullptr);
} // namespace tyndall::light_shafts::slope_rows
