// SPDX-License-Identifier: GPL-3.0-or-later
// Where shadow rays leave a smooth triangle from: interpolated normals describe a curved surface, which lies above the
// flat triangle, and at the light's horizon the triangle's neighbours would shadow what the curve leaves lit.
// Based on: the idea of Hanika, Hacking the Shadow Terminator, Ray Tracing Gems II, chapter 4, 2021: start from a
//           surface built of the vertices' tangent planes.
// Differs:  the height is Cycles' (its default geometry offset of 0.1), so that pictures agree at the terminator: half
//           the quadratic surface's height, or the lowest tangent plane's, whichever is higher; only within about 6
//           degrees of the horizon.
#pragma once
#include "scene/scene.hpp"

namespace tyndall::render {
/// Cells with normals of their own are steps of a surface that those normals describe: rays begin above the steps, wherever
/// the light is, so that what stands less than one or two cells away casts no shadow.
/// Displacement of a shadow ray's origin towards `towards_light`, scene space, metres; zero on flat triangles and away
/// from the terminator. The normal that faces the viewer must face the light, too.
[[nodiscard]] vec3 terminator_lift(const Scene& scene, const Hit& hit, const ShadingPoint& point,
                                   const vec3& towards_light);
} // namespace tyndall::render
