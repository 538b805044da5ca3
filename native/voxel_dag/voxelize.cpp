// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/voxelize.hpp"
#include "core/huge_pages.hpp"
#include "core/parallel_in_order.hpp"
#include "voxel_dag/tile_bricks.hpp"
#include "voxel_dag/tile_scan.hpp"
#include "voxel_dag/tile_triangles.hpp"
#include <bit>
#include <memory>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/task_arena.h>

namespace tyndall::voxel_dag {
namespace {
/// What a thread needs to draw a tile.
struct Workplace {
    TileBits bits;
    Bricks bricks;
    TileTriangles triangles;
    TileLines far_lines;
};
/// Bricks of one part of the cube; its vectors stay as long as the largest part has needed.
struct Part {
    std::vector<std::uint64_t> codes, masks;
    std::size_t brick_count = 0;
    std::uint64_t voxel_count = 0, tile_count = 0;
};

class Drawing {
public:
    Drawing(const SnappedMesh& mesh, VoxelizeRule rule) : mesh_(mesh), rule_(rule) {}

    /// Draws the tiles that `entries` name, which is all of one part of the cube.
    void draw(std::span<const std::uint64_t> entries, Workplace& place, Part& part) const {
        part.brick_count = part.voxel_count = part.tile_count = 0;
        for_each_tile(entries, [&](std::uint64_t tile, std::span<const std::uint64_t> its_entries) {
            place.triangles.lay(mesh_, rule_, tile, its_entries);
            const TileFrame& frame = place.triangles.frame();
            scan(place.triangles.near_lines(), place.triangles.near_count(), frame.axes, place.bits);
            for (const TileTriangles::Far& far : place.triangles.far())
                draw_far(far.corners, frame, place);
            take_bricks(place.bits, frame.axes, place.bricks);
            append(tile, place.bricks, part);
        });
    }

private:
    static void draw_far(const SnappedTriangle& triangle, const TileFrame& frame, Workplace& place) {
        TileLines& lines = place.far_lines;
        WidePlane plane;
        switch (lay_lines(triangle, frame, lines, 0, plane)) {
        case Meets::No:
            break;
        case Meets::Lines:
            scan(std::span(&lines, 1), 1, frame.axes, place.bits);
            break;
        case Meets::LinesAndWidePlane:
            scan(lines, plane, frame.axes, place.bits);
            break;
        }
    }

    static void append(std::uint64_t tile, const Bricks& bricks, Part& part) {
        ++part.tile_count;
        if (part.codes.size() < part.brick_count + tile_bricks) {
            part.codes.resize(2 * (part.brick_count + tile_bricks));
            part.masks.resize(part.codes.size());
        }
        std::uint64_t *code = part.codes.data() + part.brick_count, *mask = part.masks.data() + part.brick_count;
        std::uint64_t voxel_count = 0;
        for (std::uint64_t word = 0; word < bricks.is_full.size(); ++word)
            for (std::uint64_t full = bricks.is_full[word]; full != 0; full &= full - 1) {
                const std::uint64_t brick = word * 64 + static_cast<std::uint64_t>(std::countr_zero(full));
                *code++ = tile * tile_bricks + brick;
                *mask++ = bricks.masks[brick];
                voxel_count += static_cast<std::uint64_t>(std::popcount(bricks.masks[brick]));
            }
        part.brick_count = static_cast<std::size_t>(code - part.codes.data());
        part.voxel_count += voxel_count;
    }

    const SnappedMesh& mesh_;
    VoxelizeRule rule_;
};

void append(const std::vector<std::uint64_t>& from, std::size_t count, std::vector<std::uint64_t>& to) {
    to.insert(to.end(), from.begin(), from.begin() + static_cast<std::ptrdiff_t>(count));
}

/// Bricks of a surface grow with the square of the resolution.
void require_room(std::uint64_t brick_count, const VoxelizeConfig& config) {
    constexpr std::uint64_t bytes_per_brick = 16;
    std::uint64_t bytes = bytes_per_brick * brick_count;
    if (bytes <= config.memory_budget_bytes)
        return;
    const std::uint64_t wanted = bytes;
    std::uint32_t fits = config.resolution;
    while (fits > 1u << leaf_level && bytes > config.memory_budget_bytes)
        fits /= 2, bytes /= 4;
    refuse("the mesh makes about ", wanted >> 20, " MiB of voxels at a resolution of ", config.resolution,
           ", beyond the budget of ", config.memory_budget_bytes >> 20, " MiB; a resolution of ", fits, " would ",
           bytes <= config.memory_budget_bytes ? "fit" : "not fit either");
}

} // namespace

VoxelizeResult voxelize(const SnappedMesh& mesh, const VoxelizeConfig& config, const Progress& progress) {
    const TileBins bins = bin_triangles(mesh, progress);
    require_room(bins.expected_brick_count, config);
    VoxelizeResult result{.leaves = {.level = mesh.level, .codes = {}, .masks = {}}, .statistics = {}};
    result.statistics.triangle_tile_count = bins.entries.size();
    result.statistics.outside_triangle_count = bins.outside_triangle_count;
    for (std::vector<std::uint64_t>* const bricks : {&result.leaves.codes, &result.leaves.masks}) {
        bricks->reserve(bins.expected_brick_count);
        prefer_huge_pages(bricks->data(), bins.expected_brick_count * sizeof(std::uint64_t));
    }
    const Drawing drawing(mesh, config.rule);
    tbb::enumerable_thread_specific<std::unique_ptr<Workplace>> places([] { return std::make_unique<Workplace>(); });
    // Two for each thread: one waits for its turn while the next is drawn.
    std::vector<Part> parts(2 * static_cast<std::size_t>(tbb::this_task_arena::max_concurrency()));
    parallel_in_order(
        bins.part_count(), parts, progress,
        [&](std::size_t index, Part& part) { drawing.draw(bins.part(index), *places.local(), part); },
        [&](std::size_t, const Part& part) {
            append(part.codes, part.brick_count, result.leaves.codes);
            append(part.masks, part.brick_count, result.leaves.masks);
            result.statistics.voxel_count += part.voxel_count;
            result.statistics.tile_count += part.tile_count;
        });
    return result;
}
VoxelizeResult voxelize(std::span<const vec3> positions_m, std::span<const uvec3> triangles,
                        const VoxelizeConfig& config, const Progress& progress) {
    return voxelize(snap(positions_m, triangles, config, progress), config, progress);
}
VoxelizeResult voxelize(std::span<const dvec3> positions_m, std::span<const uvec3> triangles,
                        const VoxelizeConfig& config, const Progress& progress) {
    return voxelize(snap(positions_m, triangles, config, progress), config, progress);
}
} // namespace tyndall::voxel_dag
