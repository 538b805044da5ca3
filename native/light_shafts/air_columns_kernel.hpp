// SPDX-License-Identifier: GPL-3.0-or-later
// The vector loop that finds rays among columns of air, dispatched at run time to the best SIMD target.
#pragma once
#include "light_shafts/air_columns.hpp"

namespace tyndall::light_shafts::air_columns {
/// The cell of each ray, which is the column at its lower left, and the steps that it takes to the ray's end.
void find_cells(const AirGrid& grid, std::span<const ViewRay> rays, std::span<std::uint32_t> cells,
                std::span<std::uint32_t> steps);
} // namespace tyndall::light_shafts::air_columns
