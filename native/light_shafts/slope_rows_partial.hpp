// SPDX-License-Identifier: GPL-3.0-or-later
// Triangles that let a part of the light pass, into slope rows that hold the opaque ones: cut as those are, but a line is
// shaded only where its light meets the triangle at a point that stops it (partial_surface.hpp).
// Bound:    points behind a slope that a row already holds are not looked up; a look-up is some 20 operations per vector of
//           lines, and a material's program on the borders of an image's shapes. Bits do not depend on the threads.
#pragma once
#include "light_shafts/partial_surface.hpp"
#include "light_shafts/slope_rows_kernels.hpp"
#include <functional>

namespace tyndall::light_shafts::slope_rows {
/// As Placer; `triangle` gets indices into the block, and `weight` may be filled.
using PartialPlacer =
    std::function<std::size_t(const PartialOccluderInstance& instance, const OccluderBlock& block, std::size_t start,
                              std::int32_t first, std::int32_t end, PlacedPartials& placed)>;
/// Adds to rows that raster() has filled. Throws Cancelled.
void raster_partial(Rows& rows, const PartialShading& shading, const Progress& progress,
                    const PartialPlacer& placer = {});

/// Those that may shade a sample that matters, by their boxes.
[[nodiscard]] std::vector<PartialOccluderInstance> that_may_shade(const Layout& layout,
                                                                  std::span<const PartialOccluderInstance> instances);

/// Cuts the triangles by the slices [first, end), keeps the largest slopes that stop light, and empties `placed`.
void raster_partials(Rows& rows, std::int32_t first_slice, std::int32_t end_slice, const PartialShading& shading,
                     PlacedPartials& placed);
} // namespace tyndall::light_shafts::slope_rows
