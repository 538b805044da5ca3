// SPDX-License-Identifier: GPL-3.0-or-later
// Which triangles each tile of 64^3 voxels has to look at.
// Differs:  what spans more than two tiles is drawn conservatively into a tile whose cells are tiles: the same scan at
//           1/64 of the resolution. Both rules set voxels only where this sets their tile, ties included.
// Bound:    8 bytes per triangle and tile, twice while they are put in order.
#pragma once
#include "voxel_dag/snapped_mesh.hpp"
#include "voxel_dag/tile.hpp"

namespace tyndall::voxel_dag {
/// Tiles by parts of the cube: all tiles of one part come before those of the next in Morton order.
struct TileBins {
    static constexpr int triangle_bits = 31; ///< An entry is the tile's Morton code, above the triangle's index.
    std::vector<std::uint64_t> entries;      ///< Ascending.
    std::vector<std::size_t> first_of_part;  ///< And one behind the last.
    std::uint64_t outside_triangle_count;
    std::size_t expected_brick_count; ///< About as many as the triangles' area makes: how much to reserve, no bound.

    [[nodiscard]] std::size_t part_count() const { return first_of_part.size() - 1; }
    [[nodiscard]] std::span<const std::uint64_t> part(std::size_t index) const {
        return std::span(entries).subspan(first_of_part[index], first_of_part[index + 1] - first_of_part[index]);
    }
    [[nodiscard]] static std::uint64_t tile(std::uint64_t entry) { return entry >> triangle_bits; }
    [[nodiscard]] static std::size_t triangle(std::uint64_t entry) { return entry & ((1ull << triangle_bits) - 1); }
};
/// Throws InvalidInput for 2^31 triangles or more, and Cancelled.
[[nodiscard]] TileBins bin_triangles(const SnappedMesh& mesh, const Progress& progress);

/// Twice the triangle's area as seen along each axis, in square steps.
[[nodiscard]] std::array<double, 3> seen_along_axes(const SnappedTriangle& triangle);
/// Runs along the axis that sees the least, depth along the one that sees the most.
[[nodiscard]] ScanAxes scan_axes(const std::array<double, 3>& seen);
} // namespace tyndall::voxel_dag
