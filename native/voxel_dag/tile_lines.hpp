// SPDX-License-Identifier: GPL-3.0-or-later
// What one triangle asks of the cells of a tile, as lines that bound one index by the others.
// Based on: Schwarz and Seidel 2010, section 3; the tie rule is that of voxelize.hpp.
// Differs:  each test, c . index + e >= 0 in integers, is solved for the index along the runs (or the depth). 0.5 is
//           added to e: no test changes, and no bound is nearer than 0.5 / |c_run| to an integer, so that double
//           precision rounds it to the right one while the components of c add up to less than 2^42.
// Bound:    320 bytes per triangle and tile. For triangles near a tile see tile_lines_kernel.hpp.
#pragma once
#include "voxel_dag/snapped_mesh.hpp"
#include "voxel_dag/tile.hpp"
#include "voxel_dag/wide_integer.hpp"
#include <limits>

namespace tyndall::voxel_dag {
/// Where a tile lies: cells of 2^cell_bits steps, voxels (step_bits) or whole tiles (step_bits + tile_level).
struct TileFrame {
    std::array<std::int64_t, 3> first_cell; ///< Its lowest cell, x, y, z.
    int cell_bits;
    std::int64_t last; ///< Of the indices along each axis: 63, or less where the whole cube is smaller.
    VoxelizeRule rule;
    ScanAxes axes;
};

inline constexpr double no_bound = 1e18; ///< Beyond all indices.
inline constexpr std::size_t block_lanes = 8;
using Lanes = std::array<double, block_lanes>; ///< One of each triangle of a block.
struct Line {
    Lanes slope, offset;
};
/// Indices at least as large as each lower line and at most as large as each upper one.
template <std::size_t count>
struct Bounds {
    std::array<Line, count> lower, upper;
};
/// The same over rows and depths.
struct PlaneLine {
    Lanes row_slope, depth_slope, offset;
};
/// Of eight triangles. One that has no part in the tile has a first index beyond the last.
struct alignas(64) TileLines {
    Lanes first_run, last_run, first_row, last_row, first_depth, last_depth;
    Bounds<3> depth_by_row; ///< Three edges leave two bounds on each side; the plane may be a third.
    Bounds<2> run_by_row, run_by_depth;
    PlaneLine run_from, run_to;
};
/// A plane whose normal is too long for TileLines: lower and upper are its two tests.
struct WidePlane {
    struct Test {
        Int128 run, row, depth, offset;
    };
    Test lower, upper;
};
enum class Meets : std::uint8_t { No, Lines, LinesAndWidePlane };

/// Sets one lane of `lines`, and `plane` where it returns LinesAndWidePlane. No: its bounding box lies outside.
[[nodiscard]] Meets lay_lines(const SnappedTriangle& triangle, const TileFrame& frame, TileLines& lines,
                              std::size_t lane, WidePlane& plane);
} // namespace tyndall::voxel_dag
