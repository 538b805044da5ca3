// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/sub_volumes.hpp"
#include "core/errors.hpp"
#include "voxel_dag/tile_bins.hpp"
#include <algorithm>
#include <cmath>
#include <utility>

namespace tyndall::voxel_dag {
namespace {
constexpr std::uint32_t most_halvings = 6;

/// What a triangle's box overlaps.
struct Overlap {
    std::array<std::int64_t, 3> first, last; ///< Sub-cubes, x, y, z.
    [[nodiscard]] bool is_empty() const { return first[0] > last[0] || first[1] > last[1] || first[2] > last[2]; }
};
/// The least and the most of each coordinate.
struct Box {
    Steps least, most;
};
Box box_of(const SnappedTriangle& corners) {
    Box box{corners[0], corners[0]};
    for (const Steps& corner : corners)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            box.least[axis] = std::min(box.least[axis], corner[axis]);
            box.most[axis] = std::max(box.most[axis], corner[axis]);
        }
    return box;
}

/// A cube of sub-cubes.
class Grid {
public:
    Grid(const SnappedMesh& mesh, VoxelizeRule rule, std::uint32_t halvings)
        : mesh_(mesh), rule_(rule), halvings_(halvings) {}

    [[nodiscard]] std::size_t cell_count() const { return std::size_t{1} << 3 * halvings_; }
    [[nodiscard]] std::uint32_t level() const { return mesh_.level - halvings_; }

    /// use(Morton code, share of the triangle's bricks that is expected there).
    template <typename Use>
    void visit(std::size_t triangle, const Use& use) const {
        const SnappedTriangle corners = mesh_.triangle(triangle);
        const Box box = box_of(corners);
        const Overlap overlap = overlap_of(box);
        if (overlap.is_empty())
            return;
        const std::array<double, 3> seen = seen_along_axes(corners);
        const ScanAxes axes = scan_axes(seen);
        const double bricks = bricks_of(0.5 * seen[axes.depth]);
        for (std::int64_t z = overlap.first[2]; z <= overlap.last[2]; ++z)
            for (std::int64_t y = overlap.first[1]; y <= overlap.last[1]; ++y)
                for (std::int64_t x = overlap.first[0]; x <= overlap.last[0]; ++x) {
                    const std::array at{x, y, z};
                    const double share = share_along(box, at, axes.run) * share_along(box, at, axes.row);
                    use(morton_code({static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y),
                                     static_cast<std::uint32_t>(z)}),
                        std::max(1.0, bricks * share));
                }
    }
    /// A cube has no more than this.
    [[nodiscard]] double most_bricks() const { return std::exp2(3.0 * (level() - leaf_level)); }

private:
    [[nodiscard]] int cell_bits() const { return step_bits + static_cast<int>(level()); }
    [[nodiscard]] Overlap overlap_of(const Box& box) const {
        Overlap overlap;
        const std::int64_t last = (std::int64_t{1} << halvings_) - 1;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            overlap.first[axis] = std::max<std::int64_t>(box.least[axis] >> cell_bits(), 0);
            overlap.last[axis] = std::min(box.most[axis] >> cell_bits(), last);
        }
        return overlap;
    }
    /// Of a triangle of so many square steps, as seen along the axis that sees it best. A brick of a surface has 9 voxels
    /// or more by the thin rule, and by the other one less than twice as many voxels in a quarter more bricks.
    [[nodiscard]] double bricks_of(double seen_area) const {
        return seen_area / (9.0 * (1 << 2 * step_bits)) * (rule_ == VoxelizeRule::Thin ? 1.0 : 1.25);
    }
    /// How much of a box lies in a layer of sub-cubes.
    [[nodiscard]] double share_along(const Box& box, const std::array<std::int64_t, 3>& at, std::uint32_t axis) const {
        const std::int64_t begin = at[axis] << cell_bits(), end = (at[axis] + 1) << cell_bits();
        const std::int64_t length = box.most[axis] - box.least[axis];
        if (length == 0)
            return 1.0;
        return static_cast<double>(std::min(box.most[axis], end) - std::max(box.least[axis], begin)) /
               static_cast<double>(length);
    }

    const SnappedMesh& mesh_;
    VoxelizeRule rule_;
    std::uint32_t halvings_;
};

/// Bricks by sub-cube; 0: no triangle is near.
std::vector<double> expected_bricks(const SnappedMesh& mesh, const Grid& grid, const Progress& progress) {
    std::vector<double> bricks(grid.cell_count(), 0.0);
    for (std::size_t triangle = 0; triangle < mesh.triangles.size(); ++triangle) {
        if (triangle % 4096 == 0)
            progress.poll();
        grid.visit(triangle, [&](std::uint64_t code, double expected) { bricks[code] += expected; });
    }
    for (double& expected : bricks)
        expected = std::min(expected, grid.most_bricks());
    return bricks;
}
} // namespace

SubVolumes split(const SnappedMesh& mesh, VoxelizeRule rule, std::uint64_t most_bricks, std::uint32_t most_part_level,
                 const Progress& progress) {
    require(mesh.triangles.size() < std::size_t{1} << TileBins::triangle_bits, "the mesh has ", mesh.triangles.size(),
            " triangles; fewer than 2^", TileBins::triangle_bits, " are possible");
    const std::uint32_t most = std::min(most_halvings, mesh.level - std::min(mesh.level, tile_level));
    std::uint32_t halvings = std::min(most, mesh.level - std::min(mesh.level, most_part_level));
    std::vector<double> bricks = expected_bricks(mesh, Grid(mesh, rule, halvings), progress);
    while (std::ranges::max(bricks) > static_cast<double>(most_bricks)) {
        require(halvings < most, "a sub-cube of 2^", mesh.level - halvings, " voxels a side has about ",
                static_cast<std::uint64_t>(std::ranges::max(bricks)), " bricks of 4 x 4 x 4, of which ", most_bricks,
                " fit the budget: allow more memory or choose a smaller resolution");
        bricks = expected_bricks(mesh, Grid(mesh, rule, ++halvings), progress);
    }
    const Grid grid(mesh, rule, halvings);
    SubVolumes parts{.level = grid.level(), .codes = {}, .first = {}, .triangles = {}};
    std::vector<std::size_t> next(grid.cell_count(), 0); // by sub-cube: how many, and then where they go
    for (std::size_t triangle = 0; triangle < mesh.triangles.size(); ++triangle)
        grid.visit(triangle, [&](std::uint64_t code, double) { ++next[code]; });
    std::size_t end = 0;
    for (std::size_t code = 0; code < next.size(); ++code) {
        if (next[code] > 0) {
            parts.codes.push_back(code);
            parts.first.push_back(end);
        }
        end += std::exchange(next[code], end);
    }
    parts.first.push_back(end);
    parts.triangles.resize(end);
    for (std::size_t triangle = 0; triangle < mesh.triangles.size(); ++triangle) {
        if (triangle % 4096 == 0)
            progress.poll();
        grid.visit(triangle, [&](std::uint64_t code, double) {
            parts.triangles[next[code]++] = static_cast<std::uint32_t>(triangle);
        });
    }
    return parts;
}

SubMesh moved_mesh(const SnappedMesh& mesh, std::span<const std::uint32_t> triangles, const Voxel& at,
                   std::uint32_t part_level, std::uint32_t level) {
    SubMesh sub{.triangles = {}, .mesh = {.level = level, .positions = {}, .triangles = {}}};
    sub.triangles.reserve(triangles.size());
    sub.mesh.positions.reserve(3 * triangles.size());
    for (const std::uint32_t triangle : triangles) {
        const auto corner_count = static_cast<std::uint32_t>(sub.mesh.positions.size());
        sub.triangles.emplace_back(corner_count, corner_count + 1, corner_count + 2);
        for (Steps corner : mesh.triangle(triangle)) {
            for (std::size_t axis = 0; axis < 3; ++axis)
                corner[axis] -= std::int64_t{at[axis]} << (static_cast<std::uint32_t>(step_bits) + part_level);
            sub.mesh.positions.push_back(corner);
        }
    }
    sub.mesh.triangles = sub.triangles;
    return sub;
}

SubMesh sub_mesh(const SnappedMesh& mesh, const SubVolumes& parts, std::size_t part) {
    const auto triangles =
        std::span(parts.triangles).subspan(parts.first[part], parts.first[part + 1] - parts.first[part]);
    return moved_mesh(mesh, triangles, voxel_at(parts.codes[part]), parts.level, parts.level);
}
} // namespace tyndall::voxel_dag
