// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/solid_fill.hpp"
#include "core/parallel_in_order.hpp"
#include "voxel_dag/closed_mesh.hpp"
#include "voxel_dag/column_crossings.hpp"
#include "voxel_dag/tile_bricks.hpp"
#include <algorithm>
#include <bit>
#include <memory>
#include <tbb/task_arena.h>

namespace tyndall::voxel_dag {
namespace {
struct Inside {
    std::uint64_t voxel_count = 0;
    std::vector<std::uint64_t> tiles; ///< Morton codes of those that runs pass, in any order.
};
Inside inside_of(const ColumnCrossings& crossings, std::uint32_t resolution) {
    Inside inside;
    std::span<const std::uint64_t> left(crossings.entries);
    while (!left.empty()) {
        const std::uint64_t row = ColumnCrossings::tile_row(left.front());
        const auto count =
            static_cast<std::size_t>(std::ranges::upper_bound(left, row, {}, ColumnCrossings::tile_row) - left.begin());
        std::uint32_t least = resolution, most = 0;
        for_each_column(left.first(count), [&](std::span<const std::uint64_t> column) {
            for_each_run(column, resolution, [&](std::uint32_t from, std::uint32_t to) {
                inside.voxel_count += to - from;
                least = std::min(least, from / tile_side);
                most = std::max(most, (to - 1) / tile_side);
            });
        });
        constexpr std::uint64_t in_row = (1u << (most_level - tile_level)) - 1;
        for (std::uint32_t x = least; x <= most; ++x)
            inside.tiles.push_back(morton_code({x, static_cast<std::uint32_t>(row & in_row),
                                                static_cast<std::uint32_t>(row >> (most_level - tile_level))}));
        left = left.subspan(count);
    }
    return inside;
}

/// Bricks of the inside that lie within those of the surface are counted twice; they are few.
void require_room(std::uint64_t brick_count, std::uint64_t crossing_count, const VoxelizeConfig& config) {
    const std::uint64_t bytes = 16 * brick_count + 8 * crossing_count;
    if (bytes <= config.memory_budget_bytes)
        return;
    std::uint32_t fits = config.resolution;
    for (std::uint64_t rest = bytes; fits > 1u << leaf_level && rest > config.memory_budget_bytes; rest /= 8)
        fits /= 2;
    refuse("the solid makes about ", bytes >> 20, " MiB of voxels at a resolution of ", config.resolution,
           ", beyond the budget of ", config.memory_budget_bytes >> 20, " MiB; a resolution of ", fits, " may fit");
}

class Filling {
public:
    Filling(const ColumnCrossings& crossings, const LeafMasks& surface)
        : crossings_(crossings), surface_(surface), resolution_(static_cast<std::uint32_t>(surface.resolution())) {}

    struct Place {
        TileBits bits;
        Bricks bricks;
        std::vector<std::uint64_t> codes, masks; ///< Of the tile, with the surface's.
    };
    void fill(std::uint64_t tile, Place& place) const {
        constexpr ScanAxes axes{.run = 0, .row = 1, .depth = 2};
        const Voxel at = voxel_at(tile);
        const std::uint64_t row =
            ColumnCrossings::tile_row(ColumnCrossings::entry(0, at[1] * tile_side, at[2] * tile_side, false));
        const auto columns = std::ranges::equal_range(crossings_.entries, row, {}, ColumnCrossings::tile_row);
        const std::uint32_t begin = at[0] * tile_side, end = begin + tile_side;
        for_each_column(std::span(columns), [&](std::span<const std::uint64_t> column) {
            std::uint64_t word = 0;
            for_each_run(column, resolution_, [&](std::uint32_t from, std::uint32_t to) {
                from = std::max(from, begin), to = std::min(to, end);
                if (from < to)
                    word |= ~std::uint64_t{0} >> (tile_side - (to - from)) << (from - begin);
            });
            place.bits.words[row_place(axes).of(ColumnCrossings::y(column.front())) |
                             depth_place(axes).of(ColumnCrossings::z(column.front()))] = word;
        });
        take_bricks(place.bits, axes, place.bricks);
        add_surface(tile, place.bricks);
        list(tile, place);
    }

private:
    void add_surface(std::uint64_t tile, Bricks& bricks) const {
        auto brick = static_cast<std::size_t>(std::ranges::lower_bound(surface_.codes, tile * tile_bricks) -
                                              surface_.codes.begin());
        for (; brick < surface_.codes.size() && surface_.codes[brick] / tile_bricks == tile; ++brick) {
            const std::size_t in_tile = surface_.codes[brick] % tile_bricks;
            std::uint64_t& full = bricks.is_full[in_tile / 64];
            const std::uint64_t bit = std::uint64_t{1} << in_tile % 64;
            bricks.masks[in_tile] = surface_.masks[brick] | ((full & bit) != 0 ? bricks.masks[in_tile] : 0);
            full |= bit;
        }
    }
    static void list(std::uint64_t tile, Place& place) {
        place.codes.clear();
        place.masks.clear();
        for (std::uint64_t word = 0; word < place.bricks.is_full.size(); ++word)
            for (std::uint64_t full = place.bricks.is_full[word]; full != 0; full &= full - 1) {
                const std::uint64_t brick = word * 64 + static_cast<std::uint64_t>(std::countr_zero(full));
                place.codes.push_back(tile * tile_bricks + brick);
                place.masks.push_back(place.bricks.masks[brick]);
            }
    }

    const ColumnCrossings& crossings_;
    const LeafMasks& surface_;
    std::uint32_t resolution_;
};

template <typename Position>
void require_closed_mesh(const SnappedMesh& mesh, std::span<const Position> positions_m, const Progress& progress) {
    if (const std::optional<OpenEdge> open = open_edge(mesh, progress)) {
        const auto end = [&](int corner) { return positions_m[mesh.triangles[open->triangle][corner % 3]]; };
        const Position from = end(open->corner), to = end(open->corner + 1);
        refuse("the mesh does not close, so that it has no inside to fill: at the edge of triangle ", open->triangle,
               " from (", from.x, ", ", from.y, ", ", from.z, ") m to (", to.x, ", ", to.y, ", ", to.z,
               ") m a triangle is missing, or turned over");
    }
}
template <typename Position>
LeafMasks run(std::span<const Position> positions_m, std::span<const uvec3> triangles, const VoxelizeConfig& config,
              const LeafMasks& surface, const Progress& progress) {
    const SnappedMesh mesh = snap(positions_m, triangles, config, progress);
    require_closed_mesh(mesh, positions_m, progress);
    return filled(cross_columns(mesh, progress), surface, config, progress);
}
} // namespace

void require_closed(const SnappedMesh& mesh, std::span<const vec3> positions_m, const Progress& progress) {
    require_closed_mesh(mesh, positions_m, progress);
}
void require_closed(const SnappedMesh& mesh, std::span<const dvec3> positions_m, const Progress& progress) {
    require_closed_mesh(mesh, positions_m, progress);
}

LeafMasks filled(const ColumnCrossings& crossings, const LeafMasks& surface, const VoxelizeConfig& config,
                 const Progress& progress) {
    Inside inside = inside_of(crossings, static_cast<std::uint32_t>(surface.resolution()));
    require_room(inside.voxel_count / 64 + 2 * surface.codes.size(), crossings.entries.size(), config);
    for (std::size_t brick = 0; brick < surface.codes.size(); ++brick)
        if (const std::uint64_t tile = surface.codes[brick] / tile_bricks;
            brick == 0 || surface.codes[brick - 1] / tile_bricks != tile)
            inside.tiles.push_back(tile);
    std::ranges::sort(inside.tiles);
    const auto twice = std::ranges::unique(inside.tiles);
    inside.tiles.erase(twice.begin(), twice.end());

    LeafMasks solid{.level = surface.level, .codes = {}, .masks = {}};
    const Filling filling(crossings, surface);
    // Two for each thread: one waits for its turn while the next is filled.
    std::vector<std::unique_ptr<Filling::Place>> places(
        2 * static_cast<std::size_t>(tbb::this_task_arena::max_concurrency()));
    std::ranges::generate(places, [] { return std::make_unique<Filling::Place>(); });
    parallel_in_order(
        inside.tiles.size(), places, progress,
        [&](std::size_t index, const auto& place) { filling.fill(inside.tiles[index], *place); },
        [&](std::size_t, const auto& place) {
            solid.codes.insert(solid.codes.end(), place->codes.begin(), place->codes.end());
            solid.masks.insert(solid.masks.end(), place->masks.begin(), place->masks.end());
        });
    return solid;
}

LeafMasks solid_fill(std::span<const vec3> positions_m, std::span<const uvec3> triangles, const VoxelizeConfig& config,
                     const LeafMasks& surface, const Progress& progress) {
    return run(positions_m, triangles, config, surface, progress);
}
LeafMasks solid_fill(std::span<const dvec3> positions_m, std::span<const uvec3> triangles, const VoxelizeConfig& config,
                     const LeafMasks& surface, const Progress& progress) {
    return run(positions_m, triangles, config, surface, progress);
}
} // namespace tyndall::voxel_dag
