// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/voxelize.hpp"
#include "core/parallel.hpp"
#include "voxel_dag/tile_bins.hpp"
#include "voxel_dag/tile_bricks.hpp"
#include "voxel_dag/tile_scan.hpp"
#include <bit>
#include <memory>
#include <numeric>
#include <tbb/enumerable_thread_specific.h>

namespace tyndall::voxel_dag {
namespace {
/// What a thread needs to draw a tile.
struct Workplace {
    TileBits bits;
    Bricks bricks;
    std::vector<TileLines> lines;
};
struct Part {
    std::vector<std::uint64_t> codes, masks;
    std::uint64_t voxel_count = 0, tile_count = 0;
};

class Drawing {
public:
    Drawing(const SnappedMesh& mesh, VoxelizeRule rule) : mesh_(mesh), rule_(rule) {}

    /// Draws the tiles that `entries` name, which is all of one part of the cube.
    [[nodiscard]] Part draw(std::span<const std::uint64_t> entries, Workplace& place) const {
        Part part;
        while (!entries.empty()) {
            const std::uint64_t tile = TileBins::tile(entries.front());
            std::size_t count = 1;
            while (count < entries.size() && TileBins::tile(entries[count]) == tile)
                ++count;
            draw_tile(tile, entries.first(count), place, part);
            entries = entries.subspan(count);
        }
        return part;
    }

private:
    void draw_tile(std::uint64_t tile, std::span<const std::uint64_t> entries, Workplace& place, Part& part) const {
        std::array<double, 3> seen{};
        for (const std::uint64_t entry : entries) {
            const std::array<double, 3> areas = seen_along_axes(mesh_.triangle(TileBins::triangle(entry)));
            for (std::size_t axis = 0; axis < 3; ++axis)
                seen[axis] += areas[axis];
        }
        const Voxel at = voxel_at(tile);
        TileFrame frame{.first_cell = {at[0], at[1], at[2]},
                        .cell_bits = step_bits,
                        .last = std::min<std::int64_t>((std::int64_t{1} << mesh_.level) - 1, tile_side - 1),
                        .rule = rule_,
                        .axes = scan_axes(seen)};
        for (std::int64_t& cell : frame.first_cell)
            cell <<= tile_level;
        place.lines.resize(entries.size());
        std::size_t line_count = 0;
        for (const std::uint64_t entry : entries) {
            TileLines& lines = place.lines[line_count];
            WidePlane plane;
            const Meets meets = lay_lines(mesh_.triangle(TileBins::triangle(entry)), frame, lines, plane);
            if (meets == Meets::Lines)
                ++line_count;
            else if (meets == Meets::LinesAndWidePlane)
                scan(lines, plane, frame.axes, place.bits);
        }
        scan(std::span(place.lines).first(line_count), frame.axes, place.bits);
        take_bricks(place.bits, frame.axes, place.bricks);
        append(tile, place.bricks, part);
    }

    static void append(std::uint64_t tile, const Bricks& bricks, Part& part) {
        ++part.tile_count;
        for (std::uint64_t word = 0; word < bricks.is_full.size(); ++word)
            for (std::uint64_t full = bricks.is_full[word]; full != 0; full &= full - 1) {
                const std::uint64_t brick = word * 64 + static_cast<std::uint64_t>(std::countr_zero(full));
                part.codes.push_back(tile * tile_bricks + brick);
                part.masks.push_back(bricks.masks[brick]);
                part.voxel_count += static_cast<std::uint64_t>(std::popcount(bricks.masks[brick]));
            }
    }

    const SnappedMesh& mesh_;
    VoxelizeRule rule_;
};

template <typename Position>
VoxelizeResult run(std::span<const Position> positions_m, std::span<const uvec3> triangles,
                   const VoxelizeConfig& config, const Progress& progress) {
    const SnappedMesh mesh = snap(positions_m, triangles, config, progress);
    const TileBins bins = bin_triangles(mesh, progress);
    const Drawing drawing(mesh, config.rule);
    std::vector<Part> parts(bins.part_count());
    tbb::enumerable_thread_specific<std::unique_ptr<Workplace>> places([] { return std::make_unique<Workplace>(); });
    parallel_for(
        parts.size(), progress,
        [&](std::size_t index) {
            if (!bins.part(index).empty())
                parts[index] = drawing.draw(bins.part(index), *places.local());
        },
        1);

    VoxelizeResult result{.leaves = {.level = mesh.level, .codes = {}, .masks = {}}, .statistics = {}};
    result.statistics.triangle_tile_count = bins.entries.size();
    result.statistics.outside_triangle_count = bins.outside_triangle_count;
    std::vector<std::size_t> first{0};
    for (const Part& part : parts) {
        first.push_back(first.back() + part.codes.size());
        result.statistics.voxel_count += part.voxel_count;
        result.statistics.tile_count += part.tile_count;
    }
    result.leaves.codes.resize(first.back());
    result.leaves.masks.resize(first.back());
    parallel_for(
        parts.size(), progress,
        [&](std::size_t index) {
            const auto at = static_cast<std::ptrdiff_t>(first[index]);
            std::ranges::copy(parts[index].codes, result.leaves.codes.begin() + at);
            std::ranges::copy(parts[index].masks, result.leaves.masks.begin() + at);
            parts[index] = {};
        },
        16);
    return result;
}
} // namespace

VoxelizeResult voxelize(std::span<const vec3> positions_m, std::span<const uvec3> triangles,
                        const VoxelizeConfig& config, const Progress& progress) {
    return run(positions_m, triangles, config, progress);
}
VoxelizeResult voxelize(std::span<const dvec3> positions_m, std::span<const uvec3> triangles,
                        const VoxelizeConfig& config, const Progress& progress) {
    return run(positions_m, triangles, config, progress);
}
} // namespace tyndall::voxel_dag
