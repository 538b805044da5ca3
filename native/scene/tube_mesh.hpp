// SPDX-License-Identifier: GPL-3.0-or-later
// Strands and spheres as triangles, for what cuts triangles with planes: the exact shafts.
// Based on: Cauchy's formula: a convex body is as wide, on average over all sides, as its circumference over pi, and casts
//           a quarter of its surface.
// Bound:    48 triangles per segment of a spline, 12 of a straight one, 80 per sphere, in a tree over segments; a hexagon is
//           5 % narrower or wider than its tube from single sides, an icosahedron cut once 2 %.
#pragma once
#include "scene/strands.hpp"
#include "scene/triangle_bvh.hpp"

namespace tyndall {
class TubeMesh {
public:
    explicit TubeMesh(const Strands& strands); ///< Must outlive it.
    [[nodiscard]] std::size_t triangles_per_segment() const { return triangles_per_segment_; }
    void write(std::uint32_t segment, std::span<TriangleBvh::Triangle> triangles) const;
    /// Throws Cancelled.
    [[nodiscard]] TriangleBvh bvh(const Progress& progress) const;

private:
    const Strands& strands_;
    std::vector<TriangleBvh::Triangle> unit_sphere_; ///< Of spheres alone.
    std::size_t triangles_per_segment_;
};
} // namespace tyndall
