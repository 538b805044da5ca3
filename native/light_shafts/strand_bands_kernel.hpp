// SPDX-License-Identifier: GPL-3.0-or-later
// The vector loop of bands, dispatched at run time to the best SIMD target of the machine; the same bits on each.
#pragma once
#include "light_shafts/strand_bands.hpp"

namespace tyndall::light_shafts {
/// Rings in columns, of which one before the first and 17 behind the last of a block are there, too. A strand's first ring
/// has a negative radius.
struct RingColumns {
    const float *x, *y, *z, *radius;
};
/// Per ring two triangles to the next one, half a block apart: a point where that belongs to another strand. As many as a
/// block of occluders has.
void write_bands(const RingColumns& rings, const LightPlace& light, float* columns);
} // namespace tyndall::light_shafts
