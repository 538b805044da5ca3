// SPDX-License-Identifier: GPL-3.0-or-later
// A light's own axes, along which its masks, its noise and its gobo lie.
#pragma once
#include "scene/light.hpp"

namespace tyndall {
/// A unit vector across the unit vector `z`, as near to `x` as can be.
[[nodiscard]] vec3 across_of(const vec3& z, const vec3& x);
/// Columns x, y and z of unit length, right-handed; z towards a sun, against the beam of a spot or an area light, along
/// a point light's own Z.
[[nodiscard]] mat3 light_axes(const Light& light);
} // namespace tyndall
