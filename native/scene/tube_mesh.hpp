// SPDX-License-Identifier: GPL-3.0-or-later
// Strands and spheres as triangles, for what cuts triangles with planes: the exact shafts.
// Based on: Cauchy's formula: a convex body is as wide, on average over all sides, as its circumference over pi, and casts
//           a quarter of its surface.
// Bound:    48 triangles per segment of a spline, 12 of a straight one, 80 per sphere; a hexagon is 5 % narrower or wider
//           than its tube from single sides, an icosahedron cut once 2 %.
#pragma once
#include "scene/strands.hpp"
#include "scene/triangle_bvh.hpp"

namespace tyndall {
[[nodiscard]] MeshArrays tube_mesh(const Strands& strands);

/// No TriangleMesh: no ray ever meets them, and a tree for rays would take longer than all else of them.
struct StrandTubes {
    /// Throws Cancelled.
    StrandTubes(const SharedMeshArrays& arrays, const Progress& progress);

    Bounds3 bounds;
    TriangleBvh bvh;
};
} // namespace tyndall
