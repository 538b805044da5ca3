// SPDX-License-Identifier: GPL-3.0-or-later
// The points of a cell and those around it, one cell per lane: most of what a Voronoi pattern costs.
// Based on: Worley 1996 (see voronoi.hpp), with one point per cell.
// Differs:  places come from hash.hpp's hashes, of the cells' coordinates as floats, or as whole numbers where they are
//           permuted (Blender 5.0).
// Bound:    N hashes per cell, in lanes; 10 KiB.
#pragma once
#include "shading/patterns/hash.hpp"
#include <array>
#include <cstddef>

namespace tyndall::patterns {
/// Cells up to two away in four dimensions, and what fills the last lanes.
inline constexpr std::size_t most_points_around = 640;

template <int N>
struct PointsAround {
    std::size_t count = 0;
    /// By axis; relative to `cell`. The first coordinate is the fastest.
    alignas(64) float at[N][most_points_around];

    [[nodiscard]] Point<N> operator[](std::size_t index) const {
        Point<N> point;
        for (int axis = 0; axis < N; ++axis)
            point[axis] = at[axis][index];
        return point;
    }
};
struct PointsConfig {
    int reach = 1; ///< 1 or 2 cells.
    bool is_permuted = false;
    float randomness = 1.0f; ///< 0 leaves points at their cells' low ends.
};
/// Of the cells up to `reach` away from `cell` + `around`.
template <int N>
void find_points_around(const Point<N>& cell, const Point<N>& around, const PointsConfig& config,
                        PointsAround<N>& points);
template <>
void find_points_around(const Point<1>& cell, const Point<1>& around, const PointsConfig& config,
                        PointsAround<1>& points);
template <>
void find_points_around(const Point<2>& cell, const Point<2>& around, const PointsConfig& config,
                        PointsAround<2>& points);
template <>
void find_points_around(const Point<3>& cell, const Point<3>& around, const PointsConfig& config,
                        PointsAround<3>& points);
template <>
void find_points_around(const Point<4>& cell, const Point<4>& around, const PointsConfig& config,
                        PointsAround<4>& points);

/// Of cell `index` of those that are up to `reach` away.
template <int N>
[[nodiscard]] Point<N> offset_of(std::size_t index, int reach) {
    const auto side = static_cast<std::size_t>(2 * reach + 1);
    Point<N> offset;
    for (int axis = 0; axis < N; ++axis, index /= side)
        offset[axis] = static_cast<float>(index % side) - static_cast<float>(reach);
    return offset;
}
} // namespace tyndall::patterns
