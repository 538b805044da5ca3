// SPDX-License-Identifier: GPL-3.0-or-later
// A luminaire's measured intensities at any vector: Blender's IES Texture.
// Based on: blender/cycles v3.4.0, v4.5.0 and v5.0.0, src/kernel/svm/ies.h: which angles a vector has, and that intensities
//           between them are Catmull and Rom's curves (1974), down a column and then across. Measured in the three;
//           tests/blender/test_photometry.py compares values.
// Differs:  what stands beyond the ends of the table, which differs between versions, is in the table itself
//           (python/tyndall/photometry.py): each of its entries has the four intensities that a curve needs.
// Bound:    two searches by halving and five cubics.
#pragma once
#include "shading/surface_op.hpp"
#include <span>

namespace tyndall {
/// Whether a table is what photometric_value reads. Its first value has the numbers h and v of angles across and down, each
/// at least 2. Then come the angles in radians, rising, one in the first component of each value: h across, in [0, 2 pi],
/// and v down, in [0, pi]; then (h + 2) columns, one for each angle across and one beyond each end, of v - 1 values: from
/// each angle down but the last, the intensities at the angle before, at it, and at the two that follow.
[[nodiscard]] bool is_photometry(std::span<const vec4> table);
/// Of a table for which that holds, at a vector of any length: 0 outside of its angles, never below 0.
[[nodiscard]] float photometric_value(std::span<const vec4> table, const vec3& vector);
} // namespace tyndall
