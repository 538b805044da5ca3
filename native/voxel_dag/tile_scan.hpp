// SPDX-License-Identifier: GPL-3.0-or-later
// Draws triangles into a tile: in each row and at each depth of it, the cells a triangle sets are one run of bits.
// Based on: Schwarz and Seidel 2010, section 3, whose tests bound rows of a projection.
// Differs:  no bit is set on its own: the lanes of a vector are rows, and each writes the run between its bounds by one
//           OR. Along the axis that the normals lean to least, runs are longest.
// Bound:    per vector of rows and step of depth, 6 multiply-adds and as many minima; per run, one OR.
#pragma once
#include "voxel_dag/tile_lines.hpp"
#include <span>

namespace tyndall::voxel_dag {
/// The first `count` triangles of the blocks, by the widest vectors of this CPU (core/simd.hpp); the bits are the same
/// with each.
void scan(std::span<const TileLines> blocks, std::size_t count, const ScanAxes& axes, TileBits& bits);
/// A triangle, in lane 0, that lay_lines() calls LinesAndWidePlane.
void scan(const TileLines& lines, const WidePlane& plane, const ScanAxes& axes, TileBits& bits);

/// The runs of one triangle: bits of the word at each place. No place comes twice.
struct TriangleRuns {
    static constexpr std::size_t most = tile_side * tile_side;
    std::size_t count = 0;
    alignas(64) std::array<std::uint64_t, most + 16> places, masks; ///< Whole vectors are stored behind the last.
};
/// What scan() would set for one lane's triangle, in runs.
void list_runs(const TileLines& block, std::size_t lane, const ScanAxes& axes, TriangleRuns& runs);
void list_runs(const TileLines& lines, const WidePlane& plane, const ScanAxes& axes, TriangleRuns& runs);
} // namespace tyndall::voxel_dag
