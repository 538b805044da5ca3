// SPDX-License-Identifier: GPL-3.0-or-later
// A sparse grid of densities, trilinear between the centres of its voxels, as bricks that are read without a gather. Up to
// four densities of the same voxels lie side by side and are read together.
// Based on: Museth, VDB, ACM Trans. Graph. 32(3), 2013, for leaves of 8^3 voxels; Cycles for what lies between voxels.
// Differs:  a brick is 8^3 cells with the 9^3 voxels at their corners: a lookup reads one brick, and never a neighbour.
//           The tree above the leaves is a table of bricks, of which those without density are skipped whole.
// Bound:    2,916 bytes per brick that has density, four times as many of several, and 24 more; 4 per brick of the bounding
//           box; 8 loads and 7 lerps per lookup, of four floats each for several.
#pragma once
#include "core/math.hpp"
#include "core/progress.hpp"
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
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
    static constexpr std::size_t most_channels = 4;
    struct Brick {
        const float* corners; ///< z fastest; stride() of them each.
        vec4 greatest{0.0f};  ///< Of each channel.
    };

    /// Throws InvalidInput, which names the grid, for a density that is not finite or too large, leaves that overlap or
    /// lie too far apart, and a matrix without an inverse. Densities below 0 are 0, as in Cycles.
    DensityGrid(const GridLeaves& leaves, const Progress& progress) : DensityGrid(std::span(&leaves, 1), progress) {}
    /// One to four channels, whose voxels have to be the same. Throws as the other.
    DensityGrid(std::span<const GridLeaves> channels, const Progress& progress);
    DensityGrid(const DensityGrid&) = delete; // bricks point to what it owns
    DensityGrid& operator=(const DensityGrid&) = delete;

    [[nodiscard]] std::size_t channel_count() const { return channel_count_; }
    /// Floats from one corner to the next: 1 or 4, of which those beyond the channels are 0.
    [[nodiscard]] int stride() const { return channel_count_ == 1 ? 1 : static_cast<int>(most_channels); }

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
    /// Densities at a point of grid space, channel by channel; 0 outside.
    [[nodiscard]] vec4 at(const vec3& point) const;

private:
    [[nodiscard]] std::size_t table_index(const glm::ivec3& at) const {
        return (static_cast<std::size_t>(at.x) * static_cast<std::size_t>(table_size_.y) +
                static_cast<std::size_t>(at.y)) *
                   static_cast<std::size_t>(table_size_.z) +
               static_cast<std::size_t>(at.z);
    }

    std::size_t channel_count_ = 1;
    glm::ivec3 table_size_{0};
    std::vector<std::int32_t> table_; ///< Into bricks_, z fastest; -1: none.
    std::vector<Brick> bricks_;
    std::vector<float> corners_; ///< Brick by brick.
    Bounds3 bounds_;
    glm::dmat4 local_from_grid_{1.0};
};

/// Those of up to four channels in one register: GLM's vec4 is added float by float.
using Densities = float __attribute__((vector_size(DensityGrid::most_channels * sizeof(float))));
/// The density of a grid of one channel, a float, or Densities.
template <class Density>
inline constexpr int density_stride = std::is_same_v<Density, float> ? 1 : static_cast<int>(DensityGrid::most_channels);
/// use(Density()) with the type that a grid has.
template <class Use>
decltype(auto) with_density_type(const DensityGrid& grid, const Use& use) {
    return grid.channel_count() == 1 ? use(0.0f) : use(Densities{});
}

/// Between the corners of a brick's cell; `place` in [0, 1]^3.
template <class Density>
[[nodiscard]] Density trilinear(const float* corner, const vec3& place) {
    constexpr int stride = density_stride<Density>;
    constexpr int dy = DensityGrid::brick_corners * stride, dx = DensityGrid::brick_corners * dy;
    const auto lerp = [](const Density& a, const Density& b, float share) { return a + share * (b - a); };
    const auto at = [&](int offset) {
        Density density;
        std::memcpy(&density, corner + offset, sizeof(density));
        return density;
    };
    const auto along_z = [&](int offset) { return lerp(at(offset), at(offset + stride), place.z); };
    return lerp(lerp(along_z(0), along_z(dy), place.y), lerp(along_z(dx), along_z(dx + dy), place.y), place.x);
}
/// First corner of a cell of a brick.
[[nodiscard]] inline const float* cell_corner(const DensityGrid::Brick& brick, const glm::ivec3& cell, int stride) {
    return brick.corners +
           stride * ((cell.x * DensityGrid::brick_corners + cell.y) * DensityGrid::brick_corners + cell.z);
}
} // namespace tyndall
