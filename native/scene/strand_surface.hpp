// SPDX-License-Identifier: GPL-3.0-or-later
// Where rays have met strands and spheres, what shades there, and where rays leave them.
// Based on: Cycles, kernel/geom/curve.h and point_intersect.h.
#pragma once
#include "scene/scene.hpp"
#include "scene/strands.hpp"
#include <span>
#include <string>
#include <vector>

namespace tyndall {
/// Without view_cosine. Normals of spheres point away from their middle, as in Cycles, under uneven scales, too, where
/// they are ellipsoids.
[[nodiscard]] ShadingPoint strand_shading_point(const Strands& strands, const mat4& scene_from_object, const Ray& ray,
                                                const Hit& hit);
/// Appends what a program reads there under each name; direction: the ray's, in the scene's space.
void look_up_strand(const Strands& strands, const mat3& scene_from_object, const vec3& direction, const vec3& in_object,
                    const Hit& hit, std::span<const std::string> names, std::vector<vec2>& values);
/// Of rays on the side that was met; a sphere shades nothing of itself, whichever way they go.
[[nodiscard]] SpawnPoint strand_spawn_point(const Strands& strands, const mat4& scene_from_object, const Hit& hit);

/// Where a ray to a hit ends, so that what it ends on does not block it: before all of a strand's width, for a band faces
/// each ray, and tubes are met where an iteration ends.
[[nodiscard]] vec3 strand_arrival_point(const Strands& strands, const mat4& scene_from_object, const Hit& hit,
                                        const vec3& direction);

/// Of rays to the other side than was met: of a band, on its middle line's side that they go to, as far from it as where
/// it was met: else those that are nearly along it would cross that line, and meet the band again, which Cycles' rays leave
/// out. Of all else, `spawn`: what begins within a tube or sphere leaves it.
[[nodiscard]] SpawnPoint other_side_spawn_point(const Scene& scene, const Hit& hit, const SpawnPoint& spawn);
} // namespace tyndall
