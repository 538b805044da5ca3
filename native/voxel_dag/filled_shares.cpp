// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/filled_shares.hpp"
#include "core/parallel.hpp"
#include "voxel_dag/column_crossings.hpp"
#include "voxel_dag/solid_fill.hpp"
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace tyndall::voxel_dag {
/// Of a box, along its columns and across. A tile's columns belong to whole boxes.
static constexpr std::uint32_t along_places = 16, across_places = 4;
static constexpr std::uint32_t most_boxes = (1u << most_level) / along_places;
static_assert(tile_side % across_places == 0);

std::vector<float> filled_shares(std::span<const vec3> positions_m, std::span<const uvec3> triangles,
                                 const BoxLattice& lattice, const Progress& progress) {
    int along = 0; // the axis of columns: there are the fewest, and of several such the one that lies together
    for (int axis = 0; axis < 3; ++axis) {
        require(lattice.counts[axis] >= 1 && lattice.counts[axis] <= most_boxes, "counts: ", lattice.counts[axis],
                " boxes along an axis; 1 to ", most_boxes, " are possible");
        require(std::isfinite(lattice.step_m[axis]) && lattice.step_m[axis] > 0.0, "step_m is ", lattice.step_m[axis],
                " along an axis");
        if (lattice.counts[axis] >= lattice.counts[along])
            along = axis;
    }
    const std::array<int, 3> axes{along, (along + 1) % 3, (along + 2) % 3};
    const std::array<std::uint32_t, 3> places{along_places, across_places, across_places};
    // The mesh in places of columns, which then are voxels.
    std::vector<dvec3> turned(positions_m.size());
    std::uint32_t most = 1u << leaf_level;
    for (int axis = 0; axis < 3; ++axis) {
        const int from = axes[static_cast<std::size_t>(axis)];
        const std::uint32_t of_box = places[static_cast<std::size_t>(axis)];
        most = std::max(most, lattice.counts[from] * of_box);
        for (std::size_t index = 0; index < turned.size(); ++index)
            turned[index][axis] =
                (double{positions_m[index][from]} - lattice.lower_m[from]) / lattice.step_m[from] * of_box;
    }
    const std::uint32_t resolution = std::bit_ceil(most);
    const SnappedMesh mesh = snap(
        std::span<const dvec3>(turned), triangles,
        {.resolution = resolution, .bounds_m = Cube{.lower_m = dvec3(0.0), .side_m = static_cast<double>(resolution)}},
        progress);
    require_closed(mesh, positions_m, progress);
    const std::vector<std::uint64_t> entries = cross_columns(mesh, progress).entries;

    const uvec3& counts = lattice.counts;
    const std::array<std::size_t, 3> strides{std::size_t{counts.y} * counts.z, counts.z, 1};
    const auto stride = [&](std::size_t axis) { return strides[static_cast<std::size_t>(axes[axis])]; };
    const auto count = [&](std::size_t axis) { return counts[axes[axis]]; };
    std::vector<float> shares(std::size_t{counts.x} * strides[0]);
    std::vector<std::span<const std::uint64_t>> rows;
    for (std::span<const std::uint64_t> left(entries); !left.empty(); left = left.subspan(rows.back().size()))
        rows.push_back(left.first(static_cast<std::size_t>(
            std::ranges::upper_bound(left, ColumnCrossings::tile_row(left.front()), {}, ColumnCrossings::tile_row) -
            left.begin())));
    constexpr float of_place = 1.0f / (along_places * across_places * across_places); // a power of two: sums are exact
    parallel_for(
        rows.size(), progress,
        [&](std::size_t row) {
            const std::uint64_t tile = ColumnCrossings::tile_row(rows[row].front());
            constexpr int tile_bits = most_level - tile_level;
            const auto first_y = static_cast<std::uint32_t>(tile & ((1u << tile_bits) - 1)) * tile_side,
                       first_z = static_cast<std::uint32_t>(tile >> tile_bits) * tile_side;
            for_each_column(rows[row], [&](std::span<const std::uint64_t> column) {
                const std::uint32_t y = (first_y + ColumnCrossings::y(column.front())) / across_places,
                                    z = (first_z + ColumnCrossings::z(column.front())) / across_places;
                if (y >= count(1) || z >= count(2))
                    return;
                float* const boxes = shares.data() + y * stride(1) + z * stride(2);
                for_each_run(column, count(0) * along_places, [&](std::uint32_t from, std::uint32_t to) {
                    to = std::min(to, count(0) * along_places);
                    while (from < to) {
                        const std::uint32_t box = from / along_places, end = std::min(to, (box + 1) * along_places);
                        boxes[box * stride(0)] += of_place * static_cast<float>(end - from);
                        from = end;
                    }
                });
            });
        },
        1);
    return shares;
}
} // namespace tyndall::voxel_dag
