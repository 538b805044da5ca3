// SPDX-License-Identifier: GPL-3.0-or-later
// A sparse grid of densities, trilinear between the centres of its voxels, as bricks that are read without a gather.
// Based on: Museth, VDB, ACM Trans. Graph. 32(3), 2013, for leaves of 8^3 voxels; Cycles for what lies between voxels.
// Differs:  a brick is 8^3 cells with the 9^3 voxels at their corners: a lookup reads one brick, and never a neighbour.
//           The tree above the leaves is a table of bricks, of which those without density are skipped whole.
// Bound:    2,920 bytes per brick that has density, 4 per brick of the bounding box; 8 loads and 7 lerps per lookup.
#pragma once
#include "core/math.hpp"
#include "core/progress.hpp"
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace tyndall {
/// What a VDB file holds of one grid; outside of its leaves it is 0.
struct GridLeaves {
    static constexpr int side = 8;        ///< Voxels of a leaf.
    std::string name;                     ///< For reports.
    std::vector<glm::ivec3> origins = {}; ///< Index of each leaf's first voxel, multiples of side.
    std::vector<float> values = {};       ///< side^3 per leaf, z fastest; finite, at most 1e9.
    glm::dmat4 local_from_index{1.0};     ///< Affine; the centre of a voxel has its index.
};

/// Immutable; safe from any thread. Grid space: units of a voxel, the centre of the first voxel of the table is 0.
class DensityGrid {
public:
    static constexpr int brick_cells = 8, brick_corners = 9; ///< Per side of a brick.
    struct Brick {
        std::array<float, brick_corners * brick_corners * brick_corners> corners; ///< z fastest.
        float greatest;
    };

    /// Throws InvalidInput, which names the grid, for a density that is not finite or too large, leaves that overlap or
    /// lie too far apart, and a matrix without an inverse. Densities below 0 are 0, as in Cycles.
    DensityGrid(const GridLeaves& leaves, const Progress& progress);

    [[nodiscard]] bool is_empty() const { return bricks_.empty(); }
    /// Of the cells with density, grid space; empty without any.
    [[nodiscard]] const Bounds3& bounds() const { return bounds_; }
    [[nodiscard]] std::size_t brick_count() const { return bricks_.size(); }
    [[nodiscard]] const glm::dmat4& local_from_grid() const { return local_from_grid_; }

    /// Bricks of the table per axis.
    [[nodiscard]] const glm::ivec3& table_size() const { return table_size_; }
    /// Null: no density in it. `at` must lie in the table.
    [[nodiscard]] const Brick* brick(const glm::ivec3& at) const {
        const std::int32_t index = table_[table_index(at)];
        return index < 0 ? nullptr : &bricks_[static_cast<std::size_t>(index)];
    }
    /// Density at a point of grid space; 0 outside.
    [[nodiscard]] float at(const vec3& point) const;

private:
    [[nodiscard]] std::size_t table_index(const glm::ivec3& at) const {
        return (static_cast<std::size_t>(at.x) * static_cast<std::size_t>(table_size_.y) +
                static_cast<std::size_t>(at.y)) *
                   static_cast<std::size_t>(table_size_.z) +
               static_cast<std::size_t>(at.z);
    }

    glm::ivec3 table_size_{0};
    std::vector<std::int32_t> table_; ///< Into bricks_, z fastest; -1: none.
    std::vector<Brick> bricks_;
    Bounds3 bounds_;
    glm::dmat4 local_from_grid_{1.0};
};

/// Between the corners of a brick's cell; `place` in [0, 1]^3.
[[nodiscard]] inline float trilinear(const float* corner, const vec3& place) {
    constexpr int dx = DensityGrid::brick_corners * DensityGrid::brick_corners, dy = DensityGrid::brick_corners;
    const auto lerp = [](float a, float b, float share) { return a + share * (b - a); };
    const auto along_z = [&](int offset) { return lerp(corner[offset], corner[offset + 1], place.z); };
    return lerp(lerp(along_z(0), along_z(dy), place.y), lerp(along_z(dx), along_z(dx + dy), place.y), place.x);
}
/// First corner of a cell of a brick.
[[nodiscard]] inline const float* cell_corner(const DensityGrid::Brick& brick, const glm::ivec3& cell) {
    return brick.corners.data() + (cell.x * DensityGrid::brick_corners + cell.y) * DensityGrid::brick_corners + cell.z;
}
} // namespace tyndall
