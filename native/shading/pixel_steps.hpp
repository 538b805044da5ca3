// SPDX-License-Identifier: GPL-3.0-or-later
// How far a pixel reaches on a surface, and normals in the spaces of a point.
// Based on: blender/cycles v4.5.0, src/kernel/util/differential.h: a pixel is as wide in both directions across the
//           geometric normal, whatever the angle at which it sees the surface.
#pragma once
#include "shading/program_point.hpp"
#include <array>

namespace tyndall {
/// Geometric normal on the side of the ray.
[[nodiscard]] vec3 true_normal(const ProgramPoint& point);
[[nodiscard]] vec3 normal_in_scene(const ProgramPoint& point, const vec3& in_object); ///< Unit.
[[nodiscard]] vec3 normal_in_object(const ProgramPoint& point, const vec3& in_scene); ///< Unit.
/// Two axes across a unit normal, as Cycles turns them; unit, and at right angles to each other.
[[nodiscard]] std::array<vec3, 2> axes_across(const vec3& normal);
/// The two ways to the next pixels, in the scene; zero where the footprint is not known.
[[nodiscard]] std::array<vec3, 2> pixel_steps(const ProgramPoint& point);
} // namespace tyndall
