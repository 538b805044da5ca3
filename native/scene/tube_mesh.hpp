// SPDX-License-Identifier: GPL-3.0-or-later
// Strands and spheres as triangles, for what cuts triangles with planes: the exact shafts.
// Based on: Cauchy's formula: a convex body is as wide, on average over all sides, as its circumference over pi, and casts
//           a quarter of its surface.
// Bound:    12 triangles per piece of a spline from bend to bend (strand_bends.hpp), or per straight segment, 80 per sphere, in
//           a tree over pieces; a hexagon is 5 % narrower or wider than its tube from single sides, an icosahedron cut once
//           2 %.
#pragma once
#include "scene/strands.hpp"
#include "scene/triangle_bvh.hpp"
#include <array>

namespace tyndall {
class TubeMesh {
public:
    explicit TubeMesh(const Strands& strands); ///< Must outlive it.
    /// Of strands, or spheres.
    [[nodiscard]] std::size_t piece_count() const {
        return strands_.are_splines() ? pieces_.size() : strands_.segment_count();
    }
    [[nodiscard]] std::size_t triangles_per_piece() const { return triangles_per_piece_; }
    void write(std::size_t piece, std::span<TriangleBvh::Triangle> triangles) const;
    /// Throws Cancelled.
    [[nodiscard]] TriangleBvh bvh(const Progress& progress) const;

private:
    const Strands& strands_;
    std::vector<TriangleBvh::Triangle> unit_sphere_; ///< Of spheres alone.
    std::size_t triangles_per_piece_;
    std::vector<std::array<StrandPoint, 2>> pieces_; ///< Of splines alone: both ends.
};
} // namespace tyndall
