// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/tile_lines.hpp"
#include <algorithm>
#include <cmath>
#include <numeric>

namespace tyndall::voxel_dag {
/// Components of c that add up to this, or offsets beyond most_offset, round wrongly: see tile_lines.hpp.
static constexpr std::int64_t most_coefficients = std::int64_t{1} << 42, most_offset = std::int64_t{1} << 50;
/// Up to here, in steps from the tile's corner, products of three coordinates fit 64 bits.
static constexpr std::int64_t most_narrow = std::int64_t{1} << 18;

template <typename Integer>
static Integer magnitude(Integer value) {
    return value < 0 ? -value : value;
}
template <typename Integer, std::size_t count>
static Integer magnitude_sum(const std::array<Integer, count>& components) {
    Integer sum = 0;
    for (const Integer component : components)
        sum += magnitude(component);
    return sum;
}

template <typename Integer>
static std::int64_t clamped(Integer offset) {
    return static_cast<std::int64_t>(std::clamp<Integer>(offset, -most_offset, most_offset));
}

/// Tests against cells of one size, by one rule.
template <typename Integer>
class Tests {
public:
    Tests(int cell_bits, VoxelizeRule rule) : cell_bits_(cell_bits), rule_(rule) {}

    /// e of the test c . index + e >= 0 for "the half space c . (place - on) >= 0 meets the cell". Components in
    /// the order of the axes x, y, z, of which one may be missing.
    template <std::size_t count>
    [[nodiscard]] Integer offset(const std::array<Integer, count>& c, const std::array<Integer, count>& on) const {
        const Integer half = Integer{1} << (cell_bits_ - 1);
        Integer reach = 0, at_centre = 0; // of the cell's farthest corner or tip; of cell 0
        for (std::size_t i = 0; i < count; ++i) {
            reach = rule_ == VoxelizeRule::Thin ? std::max(reach, magnitude(c[i])) : reach + magnitude(c[i]);
            at_centre += c[i] * (half - on[i]);
        }
        const auto first = std::ranges::find_if(c, [](Integer component) { return component != 0; });
        const bool is_tie_outside = first != c.end() && *first > 0;
        return (at_centre + half * reach - Integer{is_tie_outside}) >> cell_bits_;
    }

private:
    int cell_bits_;
    VoxelizeRule rule_;
};

template <typename Integer>
using Corners = std::array<std::array<Integer, 3>, 3>; ///< In steps from the tile's lower corner.

static void leave_free(Line& line, std::size_t lane, double offset) {
    line.slope[lane] = 0;
    line.offset[lane] = offset;
}

/// Bounds of the index along `bounded` by that along `by`, of the three edges as seen along the third axis.
template <typename Integer, std::size_t count>
static void bound_by_edges(const Corners<Integer>& corners, std::uint32_t bounded, std::uint32_t by,
                           const Tests<Integer>& tests, Bounds<count>& bounds, std::size_t lane) {
    const std::uint32_t first = std::min(bounded, by), second = std::max(bounded, by);
    const auto along = [&](std::size_t edge, std::uint32_t axis) {
        return corners[(edge + 1) % 3][axis] - corners[edge][axis];
    };
    const bool is_clockwise = along(0, first) * along(1, second) < along(0, second) * along(1, first);
    std::size_t lower = 0, upper = 0; // edges of a closed outline turn both ways: two of a kind at most
    for (std::size_t edge = 0; edge < 3; ++edge) {
        const Integer sign = is_clockwise ? -1 : 1;
        // Seen edge on, the outline has no inside. Its edges then bound a strip from both sides.
        const std::array<Integer, 2> inward{-sign * along(edge, second), sign * along(edge, first)};
        const Integer of_bounded = bounded == first ? inward[0] : inward[1];
        if (of_bounded == 0)
            continue; // along `bounded`, or a point: the bounding box says the same
        const Integer offset = tests.offset(inward, {corners[edge][first], corners[edge][second]});
        const auto scale = -1.0 / static_cast<double>(of_bounded);
        Line& line = of_bounded > 0 ? bounds.lower[lower++] : bounds.upper[upper++];
        line.slope[lane] = static_cast<double>(bounded == first ? inward[1] : inward[0]) * scale;
        line.offset[lane] = (static_cast<double>(clamped(offset)) + 0.5) * scale;
    }
    for (; lower < 2; ++lower)
        leave_free(bounds.lower[lower], lane, -no_bound);
    for (; upper < 2; ++upper)
        leave_free(bounds.upper[upper], lane, no_bound);
}

/// One of the plane's two tests, c . index + offset >= 0.
template <typename Integer>
static void bound_by_plane(const std::array<Integer, 3>& c, Integer offset, const ScanAxes& axes, TileLines& lines,
                           std::size_t lane) {
    const Integer run = c[axes.run], row = c[axes.row], depth = c[axes.depth];
    const double e = static_cast<double>(clamped(offset)) + 0.5;
    if (run != 0) {
        const double scale = -1.0 / static_cast<double>(run);
        PlaneLine& line = run > 0 ? lines.run_from : lines.run_to;
        line.row_slope[lane] = static_cast<double>(row) * scale;
        line.depth_slope[lane] = static_cast<double>(depth) * scale;
        line.offset[lane] = e * scale;
    } else if (depth != 0) {
        const double scale = -1.0 / static_cast<double>(depth);
        Line& line = (depth > 0 ? lines.depth_by_row.lower : lines.depth_by_row.upper)[2];
        line.slope[lane] = static_cast<double>(row) * scale;
        line.offset[lane] = e * scale;
    } // otherwise the triangle lies in one row, as the bounding box says
}

template <typename Integer>
static std::array<Integer, 3> normal_of(const Corners<Integer>& corners) {
    std::array<Integer, 3> normal;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t b = (axis + 1) % 3, c = (axis + 2) % 3;
        normal[axis] = (corners[1][b] - corners[0][b]) * (corners[2][c] - corners[0][c]) -
                       (corners[1][c] - corners[0][c]) * (corners[2][b] - corners[0][b]);
    }
    return normal;
}

/// Whether the plane needs to be kept as integers.
template <typename Integer>
static bool lay_plane(const Corners<Integer>& corners, const ScanAxes& axes, const Tests<Integer>& tests,
                      TileLines& lines, std::size_t lane, WidePlane& plane) {
    leave_free(lines.depth_by_row.lower[2], lane, -no_bound);
    leave_free(lines.depth_by_row.upper[2], lane, no_bound);
    for (PlaneLine* const line : {&lines.run_from, &lines.run_to}) {
        line->row_slope[lane] = line->depth_slope[lane] = 0;
        line->offset[lane] = line == &lines.run_from ? -no_bound : no_bound;
    }
    std::array<Integer, 3> normal = normal_of(corners);
    if (magnitude_sum(normal) >= most_coefficients) {
        // Walls and floors have long normals that say little: (0, 0, 2^50) is (0, 0, 1).
        Integer divisor = 0;
        for (Integer component : normal)
            for (Integer rest = magnitude(component); rest != 0;) {
                const Integer remainder = divisor % rest;
                divisor = rest;
                rest = remainder;
            }
        for (Integer& component : normal)
            component /= divisor;
    }
    const std::array<Integer, 3> opposite{-normal[0], -normal[1], -normal[2]};
    const Integer lower = tests.offset(normal, corners[0]), upper = tests.offset(opposite, corners[0]);
    if (magnitude_sum(normal) < most_coefficients) {
        bound_by_plane(normal, lower, axes, lines, lane);
        bound_by_plane(opposite, upper, axes, lines, lane);
        return false;
    }
    plane.lower = {normal[axes.run], normal[axes.row], normal[axes.depth], lower};
    plane.upper = {opposite[axes.run], opposite[axes.row], opposite[axes.depth], upper};
    return true;
}

template <typename Integer>
static bool lay(const SnappedTriangle& triangle, const TileFrame& frame, TileLines& lines, std::size_t lane,
                WidePlane& plane) {
    Corners<Integer> corners;
    for (std::size_t corner = 0; corner < 3; ++corner)
        for (std::size_t axis = 0; axis < 3; ++axis)
            corners[corner][axis] = triangle[corner][axis] - (frame.first_cell[axis] << frame.cell_bits);
    const Tests<Integer> tests(frame.cell_bits, frame.rule);
    const auto& [run, row, depth] = frame.axes;
    bound_by_edges(corners, depth, row, tests, lines.depth_by_row, lane);
    bound_by_edges(corners, run, row, tests, lines.run_by_row, lane);
    bound_by_edges(corners, run, depth, tests, lines.run_by_depth, lane);
    return lay_plane(corners, frame.axes, tests, lines, lane, plane);
}

Meets lay_lines(const SnappedTriangle& triangle, const TileFrame& frame, TileLines& lines, std::size_t lane,
                WidePlane& plane) {
    std::array<double, 3> first, last; // of the indices in the bounding box
    std::int64_t farthest = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::int64_t corner = frame.first_cell[axis] << frame.cell_bits;
        const auto [least, most] = std::minmax({triangle[0][axis], triangle[1][axis], triangle[2][axis]});
        const std::int64_t from = std::max<std::int64_t>((least - corner) >> frame.cell_bits, 0),
                           to = std::min((most - corner) >> frame.cell_bits, frame.last);
        if (from > to)
            return Meets::No;
        first[axis] = static_cast<double>(from);
        last[axis] = static_cast<double>(to);
        farthest = std::max({farthest, magnitude(least - corner), magnitude(most - corner)});
    }
    const auto& [run, row, depth] = frame.axes;
    lines.first_run[lane] = first[run], lines.last_run[lane] = last[run];
    lines.first_row[lane] = first[row], lines.last_row[lane] = last[row];
    lines.first_depth[lane] = first[depth], lines.last_depth[lane] = last[depth];
    const bool is_wide = farthest < most_narrow ? lay<std::int64_t>(triangle, frame, lines, lane, plane)
                                                : lay<Int128>(triangle, frame, lines, lane, plane);
    return is_wide ? Meets::LinesAndWidePlane : Meets::Lines;
}
} // namespace tyndall::voxel_dag
