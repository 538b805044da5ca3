// SPDX-License-Identifier: GPL-3.0-or-later
// Corners of meshes that their materials move: which one moves a vertex, and what their normals are afterwards.
// Based on: Cycles without adaptive subdivision: a vertex is moved by the first of its triangles that has a
// displacement; then normals are means of the unit normals of the triangles around.
// All vertices of triangles are in range.
#pragma once
#include "core/math.hpp"
#include "core/progress.hpp"
#include <span>
#include <vector>

namespace tyndall {
/// Of each vertex of moved triangles, in the order of vertices, the first corner there: 3 * triangle + 0 to 2.
[[nodiscard]] std::vector<std::uint32_t> first_corners(std::span<const uvec3> triangles, std::span<const bool> is_moved,
                                                       std::size_t vertex_count);

/// Unit; zero of a triangle without an area.
[[nodiscard]] vec3 face_normal(std::span<const vec3> positions, const uvec3& triangle);

/// Gives all corners at vertices of renewed triangles the mean normal of those; but zero, flat, stays.
void renew_normals(std::span<const vec3> positions, std::span<const uvec3> triangles, std::span<const bool> is_renewed,
                   std::span<vec3> corner_normals, const Progress& progress);
} // namespace tyndall
