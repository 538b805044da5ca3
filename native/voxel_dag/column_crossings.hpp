// SPDX-License-Identifier: GPL-3.0-or-later
// Where a mesh crosses the lines along x through the centres of voxels, exactly.
// Differs:  a crossing is told by the first centre beyond it. Ties are broken as voxelize.hpp says, by a mesh that is moved
//           by (e, e^2, e^3): each line passes through the inside of a triangle or beside it, and beside all centres.
// Bound:    three divisions per row of a triangle and one per crossing, of 64 bits where a triangle is less than 2,048
//           voxels large; 8 bytes per crossing, twice while they are put in order.
#pragma once
#include "voxel_dag/snapped_mesh.hpp"
#include "voxel_dag/tile.hpp"
#include <span>

namespace tyndall::voxel_dag {
/// Crossings in order: those of 64 x 64 columns of a row of tiles, of one column after the other, lower ones first.
struct ColumnCrossings {
    static constexpr int first_bits = 18, column_bits = 2 * static_cast<int>(tile_level);
    std::vector<std::uint64_t> entries;

    /// y of the tile's row, and above it z.
    [[nodiscard]] static std::uint64_t tile_row(std::uint64_t entry) { return entry >> (1 + first_bits + column_bits); }
    [[nodiscard]] static std::uint32_t y(std::uint64_t entry) { return entry >> (1 + first_bits) & (tile_side - 1); }
    [[nodiscard]] static std::uint32_t z(std::uint64_t entry) {
        return entry >> (1 + first_bits + tile_level) & (tile_side - 1);
    }
    /// x of the first voxel whose centre lies beyond; below the resolution, 0 for all that lies before.
    [[nodiscard]] static std::uint32_t first(std::uint64_t entry) { return entry >> 1 & ((1u << first_bits) - 1); }
    /// Towards +x out of the mesh (-1) or into it (1).
    [[nodiscard]] static int turn(std::uint64_t entry) { return (entry & 1) != 0 ? 1 : -1; }
    [[nodiscard]] static std::uint64_t entry(std::uint32_t first, std::uint32_t at_y, std::uint32_t at_z,
                                             bool is_into) {
        const std::uint64_t row = std::uint64_t{at_z >> tile_level} << (most_level - tile_level) | at_y >> tile_level;
        const std::uint64_t column = (at_z & (tile_side - 1)) << tile_level | (at_y & (tile_side - 1));
        return ((row << column_bits | column) << first_bits | first) << 1 | std::uint64_t{is_into};
    }
};
/// sums_before: of those before all voxels a column has as many as they add up to, and 4 bytes; where most lie there.
[[nodiscard]] ColumnCrossings cross_columns(const SnappedMesh& mesh, const Progress& progress,
                                            bool sums_before = false);

/// use(the crossings of one column) for each column.
template <typename Use>
void for_each_column(std::span<const std::uint64_t> entries, const Use& use) {
    constexpr int below = 1 + ColumnCrossings::first_bits;
    while (!entries.empty()) {
        std::size_t count = 1;
        while (count < entries.size() && entries[count] >> below == entries.front() >> below)
            ++count;
        use(entries.first(count));
        entries = entries.subspan(count);
    }
}
/// use(from, to) for the runs of voxels, without the last, that the mesh winds around; of one column.
template <typename Use>
void for_each_run(std::span<const std::uint64_t> column, std::uint32_t resolution, const Use& use) {
    int winding = 0;
    for (std::size_t i = 0; i < column.size(); ++i) {
        winding += ColumnCrossings::turn(column[i]);
        const std::uint32_t from = ColumnCrossings::first(column[i]),
                            to = i + 1 < column.size() ? ColumnCrossings::first(column[i + 1]) : resolution;
        if (winding != 0 && from < to)
            use(from, to);
    }
}
} // namespace tyndall::voxel_dag
