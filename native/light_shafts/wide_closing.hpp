// SPDX-License-Identifier: GPL-3.0-or-later
// A closing whose kernel is many texels wide, at a cost that does not grow with its width: what is filled is found on a
// coarser map, and everything else stays as fine as it was.
// Based on: closings are extensive: they never take away what was there.
// Error:    the border of what is filled lies within two texels of the coarse map: 1/20 of the kernel's radius. Kernels
//           with a radius of up to 40 texels have none.
// Bound:    one look at each texel, and flat_filters' closing of a map with a radius of 20 to 40 texels.
#pragma once
#include "light_shafts/flat_filters.hpp"

namespace tyndall::light_shafts {
inline constexpr float widest_exact_radius_texels = 40.0f;
/// As flat_filters::close_map. Throws InvalidInput and Cancelled.
void close_wide(flat_filters::MapSpan map, KernelShape shape, float radius_texels, const Progress& progress);
} // namespace tyndall::light_shafts
