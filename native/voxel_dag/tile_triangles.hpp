// SPDX-License-Identifier: GPL-3.0-or-later
// The triangles of one tile, as lines that bound its voxels: what sets voxels and what asks for their attributes share.
// Differs:  triangles near the tile are laid in blocks, by vectors; the few far ones stay as they are, for lay_lines().
// Bound:    tile_lines_kernel.hpp's; 400 bytes of room per triangle of the tile that has most.
#pragma once
#include "voxel_dag/tile_bins.hpp"
#include "voxel_dag/tile_lines_kernel.hpp"

namespace tyndall::voxel_dag {
class TileTriangles {
public:
    struct Far {
        std::size_t triangle; ///< Of the mesh.
        SnappedTriangle corners;
    };
    /// entries: all of `tile`, and nothing else (TileBins).
    void lay(const SnappedMesh& mesh, VoxelizeRule rule, std::uint64_t tile, std::span<const std::uint64_t> entries);

    [[nodiscard]] const TileFrame& frame() const { return frame_; }
    [[nodiscard]] std::size_t near_count() const { return near_triangles_.size(); }
    /// Of the mesh, as many as near_count().
    [[nodiscard]] std::span<const std::size_t> near_triangles() const { return near_triangles_; }
    /// Blocks of them; those behind the last triangle hold anything.
    [[nodiscard]] std::span<const TileLines> near_lines() const { return lines_; }
    [[nodiscard]] std::span<const Far> far() const { return far_; }

private:
    void gather(const SnappedMesh& mesh, std::span<const std::uint64_t> entries);

    TileFrame frame_;
    std::vector<NearTriangles> near_;
    std::vector<std::size_t> near_triangles_;
    std::vector<TileLines> lines_;
    std::vector<Far> far_;
};

/// use(tile, its entries) for each tile of some entries, in their order.
template <typename Use>
void for_each_tile(std::span<const std::uint64_t> entries, const Use& use) {
    while (!entries.empty()) {
        const std::uint64_t tile = TileBins::tile(entries.front());
        std::size_t count = 1;
        while (count < entries.size() && TileBins::tile(entries[count]) == tile)
            ++count;
        use(tile, entries.first(count));
        entries = entries.subspan(count);
    }
}
} // namespace tyndall::voxel_dag
