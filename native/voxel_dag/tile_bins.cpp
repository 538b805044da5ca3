// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/tile_bins.hpp"
#include "core/huge_pages.hpp"
#include "core/parallel.hpp"
#include "voxel_dag/tile_scan.hpp"
#include <bit>
#include <cmath>
#include <memory>
#include <numeric>

namespace tyndall::voxel_dag {
std::array<double, 3> seen_along_axes(const SnappedTriangle& triangle) {
    std::array<double, 3> areas;
    const auto along = [&](std::size_t corner, std::size_t axis) {
        return static_cast<double>(triangle[corner][axis] - triangle[0][axis]);
    };
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t b = (axis + 1) % 3, c = (axis + 2) % 3;
        areas[axis] = std::abs(along(1, b) * along(2, c) - along(1, c) * along(2, b));
    }
    return areas;
}

ScanAxes scan_axes(const std::array<double, 3>& seen) {
    ScanAxes axes{0, 1, 2};
    if (seen[axes.run] > seen[axes.row])
        std::swap(axes.run, axes.row);
    if (seen[axes.row] > seen[axes.depth])
        std::swap(axes.row, axes.depth);
    if (seen[axes.run] > seen[axes.row])
        std::swap(axes.run, axes.row);
    return axes;
}

namespace {
constexpr int tile_bits = step_bits + static_cast<int>(tile_level); ///< A tile is 2^14 steps wide.
constexpr std::uint32_t most_part_level = 4;                        ///< 16 parts a side.

/// Tiles from `first` to `last`, x, y, z.
struct TileBox {
    std::array<std::int64_t, 3> first, last;
    [[nodiscard]] bool is_empty() const { return first[0] > last[0] || first[1] > last[1] || first[2] > last[2]; }
    [[nodiscard]] bool is_small() const {
        return last[0] - first[0] < 2 && last[1] - first[1] < 2 && last[2] - first[2] < 2;
    }
    template <typename Visit>
    void visit(const Visit& use) const {
        for (std::int64_t z = first[2]; z <= last[2]; ++z)
            for (std::int64_t y = first[1]; y <= last[1]; ++y)
                for (std::int64_t x = first[0]; x <= last[0]; ++x)
                    use(std::array{x, y, z});
    }
};

class Binning {
public:
    explicit Binning(const SnappedMesh& mesh)
        : mesh_(mesh), tile_level_of_cube_(mesh.level - std::min(mesh.level, tile_level)),
          part_shift_(TileBins::triangle_bits +
                      3 * static_cast<int>(tile_level_of_cube_ - std::min(tile_level_of_cube_, most_part_level))) {}

    [[nodiscard]] std::size_t part_count() const {
        return std::size_t{1} << 3 * std::min(tile_level_of_cube_, most_part_level);
    }
    [[nodiscard]] std::size_t part_of(std::uint64_t entry) const { return entry >> part_shift_; }
    [[nodiscard]] int part_shift() const { return part_shift_; }

    /// Appends the entries of one triangle; false: it is outside.
    bool bin(std::size_t triangle, TileBits& scratch, std::vector<std::uint64_t>& entries) const {
        const SnappedTriangle corners = mesh_.triangle(triangle);
        const TileBox box = box_of(corners);
        if (box.is_empty())
            return false;
        const auto append = [&](const std::array<std::int64_t, 3>& tile) {
            const Voxel at{static_cast<std::uint32_t>(tile[0]), static_cast<std::uint32_t>(tile[1]),
                           static_cast<std::uint32_t>(tile[2])};
            entries.push_back(morton_code(at) << TileBins::triangle_bits | triangle);
        };
        if (box.is_small())
            box.visit(append);
        else
            scan_tiles(corners, box, scratch, append);
        return true;
    }

private:
    [[nodiscard]] std::int64_t last_tile() const { return (std::int64_t{1} << tile_level_of_cube_) - 1; }
    [[nodiscard]] TileBox box_of(const SnappedTriangle& corners) const {
        TileBox box;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::int64_t a = corners[0][axis], b = corners[1][axis], c = corners[2][axis];
            const std::int64_t least = std::min(a, std::min(b, c)), most = std::max(a, std::max(b, c));
            box.first[axis] = std::max<std::int64_t>(least >> tile_bits, 0);
            box.last[axis] = std::min(most >> tile_bits, last_tile());
            // A cube of less than one tile has no whole last tile.
            if (least >= std::int64_t{1} << (mesh_.level + step_bits))
                box.first[axis] = box.last[axis] + 1;
        }
        return box;
    }
    template <typename Append>
    void scan_tiles(const SnappedTriangle& corners, const TileBox& box, TileBits& scratch, const Append& append) const {
        const ScanAxes axes = scan_axes(seen_along_axes(corners));
        TileBox blocks = box; // of 64^3 tiles
        for (std::size_t axis = 0; axis < 3; ++axis) {
            blocks.first[axis] >>= tile_level;
            blocks.last[axis] >>= tile_level;
        }
        blocks.visit([&](const std::array<std::int64_t, 3>& block) {
            TileFrame frame{.first_cell = block,
                            .cell_bits = tile_bits,
                            .last = std::min<std::int64_t>(last_tile(), tile_side - 1),
                            .rule = VoxelizeRule::Conservative,
                            .axes = axes};
            for (std::int64_t& cell : frame.first_cell)
                cell <<= tile_level;
            TileLines lines;
            WidePlane plane;
            switch (lay_lines(corners, frame, lines, 0, plane)) {
            case Meets::No:
                return;
            case Meets::Lines:
                scan(std::span(&lines, 1), 1, axes, scratch);
                break;
            case Meets::LinesAndWidePlane:
                scan(lines, plane, axes, scratch);
                break;
            }
            take_tiles(lines, frame, scratch, append);
        });
    }
    /// What is set in the rows and depths of `lines`; clears it.
    template <typename Append>
    static void take_tiles(const TileLines& lines, const TileFrame& frame, TileBits& scratch, const Append& append) {
        const auto& axes = frame.axes;
        for (auto row = static_cast<std::uint32_t>(lines.first_row[0]); row <= lines.last_row[0]; ++row)
            for (auto depth = static_cast<std::uint32_t>(lines.first_depth[0]); depth <= lines.last_depth[0]; ++depth) {
                std::uint64_t& word = scratch.words[row_place(axes).of(row) | depth_place(axes).of(depth)];
                for (; word != 0; word &= word - 1) {
                    std::array<std::int64_t, 3> tile = frame.first_cell;
                    tile[axes.run] += std::countr_zero(word);
                    tile[axes.row] += row;
                    tile[axes.depth] += depth;
                    append(tile);
                }
            }
    }

    const SnappedMesh& mesh_;
    std::uint32_t tile_level_of_cube_; ///< 2^this tiles a side.
    int part_shift_;
};

/// Entries of one part, by the bits of the tile that lie below `part_shift`; those of one tile stay in their order.
void sort_by_tile(std::span<std::uint64_t> entries, int part_shift) {
    constexpr int digit_bits = 9;
    std::vector<std::uint64_t> sorted(entries.size());
    for (int shift = TileBins::triangle_bits; shift < part_shift; shift += digit_bits) {
        const auto digit = [&](std::uint64_t entry) {
            return entry >> shift & ((1u << std::min(digit_bits, part_shift - shift)) - 1);
        };
        std::array<std::uint32_t, 1 << digit_bits> next{};
        for (const std::uint64_t entry : entries)
            ++next[digit(entry)];
        std::exclusive_scan(next.begin(), next.end(), next.begin(), 0u);
        for (const std::uint64_t entry : entries)
            sorted[next[digit(entry)]++] = entry;
        std::ranges::copy(sorted, entries.begin());
    }
}
} // namespace

TileBins bin_triangles(const SnappedMesh& mesh, const Progress& progress) {
    const std::size_t count = mesh.triangles.size();
    require(count < std::size_t{1} << TileBins::triangle_bits, "the mesh has ", count, " triangles; fewer than 2^",
            TileBins::triangle_bits, " are possible");
    const Binning binning(mesh);
    const std::size_t block_size = std::max<std::size_t>(std::size_t{1} << 12, count / 256 + 1);
    struct Block {
        std::vector<std::uint64_t> entries;
        std::vector<std::size_t> next; ///< By part: how many, and then where they go.
        std::uint64_t outside_count = 0;
        double seen_area = 0; ///< Each triangle's, along the axis that sees it best, in square steps.
    };
    std::vector<Block> blocks((count + block_size - 1) / block_size);
    parallel_blocks(count, block_size, progress, [&](std::size_t begin, std::size_t end) {
        Block& block = blocks[begin / block_size];
        const auto scratch = std::make_unique<TileBits>();
        block.entries.reserve(2 * (end - begin));
        for (std::size_t triangle = begin; triangle < end; ++triangle) {
            constexpr std::size_t ahead = 12;
            if (triangle + ahead < end)
                for (int corner = 0; corner < 3; ++corner)
                    __builtin_prefetch(&mesh.positions[mesh.triangles[triangle + ahead][corner]]);
            if (binning.bin(triangle, *scratch, block.entries))
                block.seen_area += 0.5 * std::ranges::max(seen_along_axes(mesh.triangle(triangle)));
            else
                ++block.outside_count;
        }
        block.next.resize(binning.part_count());
        for (const std::uint64_t entry : block.entries)
            ++block.next[binning.part_of(entry)];
    });

    TileBins bins{.entries = {}, .first_of_part = {0}, .outside_triangle_count = 0, .expected_brick_count = 0};
    for (std::size_t part = 0; part < binning.part_count(); ++part) {
        std::size_t end = bins.first_of_part.back();
        for (Block& block : blocks)
            end += std::exchange(block.next[part], end);
        bins.first_of_part.push_back(end);
    }
    double seen_area = 0;
    for (const Block& block : blocks) {
        bins.outside_triangle_count += block.outside_count;
        seen_area += block.seen_area;
    }
    // A brick of a surface has 9 voxels or more, if it is no dust; a flat triangle meets 512 bricks of a tile at most.
    bins.expected_brick_count = static_cast<std::size_t>(
        std::min(seen_area / (9.0 * (1 << 2 * step_bits)), 512.0 * static_cast<double>(bins.first_of_part.back())));
    bins.entries = large_vector<std::uint64_t>(bins.first_of_part.back());
    parallel_for(
        blocks.size(), progress,
        [&](std::size_t index) {
            for (const std::uint64_t entry : blocks[index].entries)
                bins.entries[blocks[index].next[binning.part_of(entry)]++] = entry;
        },
        1);
    parallel_for(
        bins.part_count(), progress,
        [&](std::size_t part) {
            sort_by_tile(
                std::span(bins.entries)
                    .subspan(bins.first_of_part[part], bins.first_of_part[part + 1] - bins.first_of_part[part]),
                binning.part_shift());
        },
        16);
    return bins;
}
} // namespace tyndall::voxel_dag
