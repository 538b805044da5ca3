// SPDX-License-Identifier: GPL-3.0-or-later
// Where rays go on from mirrors and from glass.
// Based on: the law of reflection and Snell's law.
// Differs:  a normal that is not the surface's own, a smooth or a bumped one, may send a ray to the wrong side of the
//           surface. Cycles loses its light; here it goes on as from the flat surface.
#pragma once
#include "render/surface_point.hpp"
#include <optional>

namespace tyndall::render {
/// Around a unit normal on the ray's side.
[[nodiscard]] Ray mirrored_ray(const SurfacePoint& point, const Ray& ray, const vec3& normal);
/// Into what has an index `ior` times that of the ray's side; nothing where all is reflected.
[[nodiscard]] std::optional<Ray> bent_ray(const Scene& scene, const SurfacePoint& point, const Ray& ray,
                                          const vec3& normal, float ior);
} // namespace tyndall::render
