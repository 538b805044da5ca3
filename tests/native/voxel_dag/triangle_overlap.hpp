// SPDX-License-Identifier: GPL-3.0-or-later
// The voxels of a triangle by looking at each voxel of its bounding box on its own: the truth for voxelize().
// Based on: Schwarz and Seidel, ACM TOG 29(6), 2010, section 3.
// Differs:  written as directions in space, and how far the voxel and the triangle's edge reach along each; 128 bits, or 64
//           where they suffice. Shares no code with voxelize().
#pragma once
#include "voxel_dag/voxelize.hpp"
#include <algorithm>
#include <array>
#include <vector>

namespace tyndall::voxel_dag::oracle {
__extension__ typedef __int128 Wide;
using Point = std::array<std::int64_t, 3>; ///< In steps of 1/256 voxel.
using Triangle = std::array<Point, 3>;
template <class Number>
using Direction = std::array<Number, 3>;
inline constexpr std::int64_t steps_per_voxel = 256;

template <class Number>
Number dot(const Direction<Number>& direction, const Point& point) {
    return direction[0] * point[0] + direction[1] * point[1] + direction[2] * point[2];
}
template <class Number>
Direction<Number> cross(const Point& a, const Point& b) {
    return {Number{a[1]} * b[2] - Number{a[2]} * b[1], Number{a[2]} * b[0] - Number{a[0]} * b[2],
            Number{a[0]} * b[1] - Number{a[1]} * b[0]};
}
inline Point between(const Point& from, const Point& to) { return {to[0] - from[0], to[1] - from[1], to[2] - from[2]}; }

template <class Number>
class OverlapIn {
public:
    OverlapIn(const Triangle& triangle, VoxelizeRule rule) : triangle_(triangle), rule_(rule) {
        const Direction<Number> normal =
            cross<Number>(between(triangle[0], triangle[1]), between(triangle[0], triangle[2]));
        add(normal, triangle[0]);
        add(opposite(normal), triangle[0]);
        for (std::size_t edge = 0; edge < 3; ++edge)
            for (std::size_t axis = 0; axis < 3; ++axis) {
                Point along{};
                along[axis] = 1;
                const Point &from = triangle[edge], &to = triangle[(edge + 1) % 3], &third = triangle[(edge + 2) % 3];
                const Direction<Number> across = cross<Number>(between(from, to), along);
                if (dot(across, third) >= dot(across, from))
                    add(across, from);
                if (dot(across, third) <= dot(across, from))
                    add(opposite(across), from);
            }
    }
    bool operator()(const Voxel& voxel) const {
        const Point centre = centre_of(voxel, 1);
        return is_in_box(voxel, 1) && std::ranges::all_of(halves_, [&](const Half& half) {
                   const Number farthest =
                       dot(half.inward, centre) + half.reach; // of the voxel, towards the triangle's inside
                   return farthest > half.edge || (farthest == half.edge && half.counts_tie);
               });
    }
    /// False only where no voxel of a cube overlaps.
    bool may_meet(const Voxel& lowest, std::uint32_t side) const {
        const Point centre = centre_of(lowest, side);
        return is_in_box(lowest, side) && std::ranges::all_of(halves_, [&](const Half& half) {
                   return dot(half.inward, centre) + half.corner_reach * side >= half.edge;
               });
    }

private:
    struct Half {
        Direction<Number> inward;
        Number edge, reach, corner_reach;
        bool counts_tie;
    };
    static Point centre_of(const Voxel& lowest, std::uint32_t side) {
        const auto at = [&](std::size_t axis) {
            return steps_per_voxel * lowest[axis] + steps_per_voxel / 2 * std::int64_t{side};
        };
        return {at(0), at(1), at(2)};
    }
    bool is_in_box(const Voxel& lowest, std::uint32_t side) const {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::int64_t lower = steps_per_voxel * lowest[axis];
            const auto [least, most] = std::minmax({triangle_[0][axis], triangle_[1][axis], triangle_[2][axis]});
            if (most < lower || least >= lower + steps_per_voxel * side)
                return false;
        }
        return true;
    }
    static Direction<Number> opposite(const Direction<Number>& direction) {
        return {-direction[0], -direction[1], -direction[2]};
    }
    void add(const Direction<Number>& inward, const Point& on) {
        Number largest = 0, sum = 0, moves = 0; // moves: as (e, e^2, e^3) does the mesh, along `inward`
        for (const Number component : inward) {
            const Number size = component < 0 ? -component : component;
            largest = std::max(largest, size);
            sum += size;
            if (moves == 0)
                moves = component;
        }
        const Number to_corner = sum * (steps_per_voxel / 2);
        const Number reach = rule_ == VoxelizeRule::Thin ? largest * (steps_per_voxel / 2) : to_corner;
        halves_.push_back({inward, dot(inward, on), reach, to_corner, moves <= 0});
    }
    Triangle triangle_;
    VoxelizeRule rule_;
    std::vector<Half> halves_;
};
using Overlap = OverlapIn<Wide>;

/// Of all triangles, in a cube of 2^level voxels a side.
inline LeafMasks voxels_of(const std::vector<Triangle>& triangles, std::uint32_t level, VoxelizeRule rule) {
    std::vector<Voxel> voxels;
    const std::int64_t last = (std::int64_t{1} << level) - 1;
    for (const Triangle& triangle : triangles) {
        const Overlap overlaps(triangle, rule);
        std::array<std::uint32_t, 3> from, to; // `to` is one behind
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto [least, most] = std::minmax({triangle[0][axis], triangle[1][axis], triangle[2][axis]});
            from[axis] = static_cast<std::uint32_t>(std::clamp<std::int64_t>(least / steps_per_voxel, 0, last));
            to[axis] = static_cast<std::uint32_t>(std::clamp<std::int64_t>(most / steps_per_voxel, 0, last)) + 1;
        }
        for (std::uint32_t z = from[2]; z < to[2]; ++z)
            for (std::uint32_t y = from[1]; y < to[1]; ++y)
                for (std::uint32_t x = from[0]; x < to[0]; ++x)
                    if (overlaps({x, y, z}))
                        voxels.push_back({x, y, z});
    }
    return leaf_masks_of(std::move(voxels), level);
}
} // namespace tyndall::voxel_dag::oracle
