// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/tile_triangles.hpp"

namespace tyndall::voxel_dag {
void TileTriangles::lay(const SnappedMesh& mesh, VoxelizeRule rule, std::uint64_t tile,
                        std::span<const std::uint64_t> entries) {
    const Voxel at = voxel_at(tile);
    frame_ = {.first_cell = {at[0], at[1], at[2]},
              .cell_bits = step_bits,
              .last = std::min<std::int64_t>((std::int64_t{1} << mesh.level) - 1, tile_side - 1),
              .rule = rule,
              .axes = {}};
    for (std::int64_t& cell : frame_.first_cell)
        cell <<= tile_level;
    gather(mesh, entries);
    const std::span near(near_.data(), (near_count() + block_lanes - 1) / block_lanes);
    std::array<double, 3> seen = seen_along_axes(near);
    for (const Far& far : far_) {
        const std::array<double, 3> areas = seen_along_axes(far.corners);
        for (std::size_t axis = 0; axis < 3; ++axis)
            seen[axis] += areas[axis];
    }
    frame_.axes = scan_axes(seen);
    lines_.resize(std::max(lines_.size(), near.size()));
    lay_near_lines(near, frame_, lines_);
}

/// Tells near triangles from far ones.
void TileTriangles::gather(const SnappedMesh& mesh, std::span<const std::uint64_t> entries) {
    near_.resize(std::max(near_.size(), entries.size() / block_lanes + 1));
    near_triangles_.resize(entries.size());
    far_.clear();
    std::size_t count = 0;
    Steps corner_of_tile;
    for (std::size_t axis = 0; axis < 3; ++axis)
        corner_of_tile[axis] = frame_.first_cell[axis] << frame_.cell_bits;
    for (std::size_t index = 0; index < entries.size(); ++index) {
        // Triangles lie anywhere in the mesh: each comes from memory while those before it are gathered. Here, as
        // GCC 12 takes a function that does nothing else for one without effect.
        constexpr std::size_t ahead = 8;
        if (index + 2 * ahead < entries.size())
            __builtin_prefetch(&mesh.triangles[TileBins::triangle(entries[index + 2 * ahead])]);
        if (index + ahead < entries.size()) {
            const uvec3& corners = mesh.triangles[TileBins::triangle(entries[index + ahead])];
            for (int corner = 0; corner < 3; ++corner)
                __builtin_prefetch(&mesh.positions[corners[corner]]);
        }
        const std::size_t triangle = TileBins::triangle(entries[index]);
        const SnappedTriangle corners = mesh.triangle(triangle);
        NearTriangles& block = near_[count / block_lanes];
        std::int64_t any = 0; // bits that a coordinate or, below 0, its complement has
        for (std::size_t corner = 0; corner < 3; ++corner)
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const std::int64_t at = corners[corner][axis] - corner_of_tile[axis];
                any |= at ^ at >> 63;
                block.corner[corner][axis][count % block_lanes] = static_cast<double>(at);
            }
        if (any < most_near)
            near_triangles_[count++] = triangle;
        else
            far_.push_back({triangle, corners});
    }
    near_triangles_.resize(count);
}
} // namespace tyndall::voxel_dag
