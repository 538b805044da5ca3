// SPDX-License-Identifier: GPL-3.0-or-later
// EXACT visibility behind shapes of cells: a cell is convex, so that what it shadows of a view ray is one interval.
// Differs:  a mesh's triangles are cut one by one (strip_kernel.hpp); here whole boxes are, from the whole shape down to
//           its cells, and a box whose interval is shadowed already is not opened.
// Bound:    24 multiply-adds and up to 12 divisions per box. Error: as a mesh of the same boxes has it.
#pragma once
#include "light_shafts/strip_kernel.hpp"
#include "scene/cell_shape.hpp"

namespace tyndall::light_shafts {
/// Adds what a shape shadows of the ray; `shadow` was reset for it.
void add_shape_shadows(const CellShape& shape, const mat4& scene_from_object, const StripRay& ray, ShadowUnion& shadow);
} // namespace tyndall::light_shafts
