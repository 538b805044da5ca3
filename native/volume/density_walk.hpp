// SPDX-License-Identifier: GPL-3.0-or-later
// Along a line through a density grid, cell by cell; bricks without density are stepped over.
// Based on: Amanatides and Woo, A Fast Voxel Traversal Algorithm, Eurographics 1987, once over bricks and once in them.
// Differs:  the integral of the density over a cell is exact: trilinear along a line is a cubic, and Gauss' rule of two
//           points integrates cubics exactly. The optical depth of a medium that a grid modulates has no other error.
// Bound:    two lookups and a step per cell, one step per empty brick.
#pragma once
#include "volume/density_grid.hpp"
#include <algorithm>
#include <span>

namespace tyndall {
/// origin + t direction in grid space; t in metres of the scene.
struct GridLine {
    glm::dvec3 origin, direction;
    [[nodiscard]] glm::dvec3 at(double t) const { return origin + t * direction; }
};

/// A stretch of a line within one cell of a grid of one channel, float, or of several, Densities.
template <class Density>
struct CellSpan {
    using Integral = std::conditional_t<std::is_same_v<Density, float>, double, Densities>;

    double near_m, far_m;
    const float* corner;   ///< Of its brick.
    vec3 entry, direction; ///< Place in the cell at near_m, and its change per metre.

    [[nodiscard]] Density density(double t) const {
        return trilinear<Density>(corner, glm::clamp(entry + static_cast<float>(t - near_m) * direction, 0.0f, 1.0f));
    }
    /// Of the density over [from_m, to_m], a part of the span: density times metres.
    [[nodiscard]] Integral integral(double from_m, double to_m) const {
        constexpr double gauss = 0.57735026918962576; // 1 / sqrt(3)
        const double middle = 0.5 * (from_m + to_m), half = 0.5 * (to_m - from_m);
        const Density before = density(middle - gauss * half), behind = density(middle + gauss * half);
        if constexpr (std::is_same_v<Density, float>)
            return half * (double{before} + behind);
        else
            return static_cast<float>(half) * (before + behind);
    }
};

/// Adds what CellSpan::integral() gives to the sums of all channels.
inline void add_integral(glm::dvec4& sum, double integral) { sum.x += integral; }
inline void add_integral(glm::dvec4& sum, const Densities& integral) {
    for (int channel = 0; channel < 4; ++channel)
        sum[channel] += integral[channel];
}

struct LinePart {
    double near_m, far_m;
};
/// Whether some part holds the distance.
[[nodiscard]] inline bool is_inside(std::span<const LinePart> parts, double at_m) {
    return std::ranges::any_of(parts, [&](const LinePart& part) { return part.near_m < at_m && at_m < part.far_m; });
}
/// Where a part begins or ends next after from_m; end_m if none does before.
[[nodiscard]] inline double next_end(std::span<const LinePart> parts, double from_m, double end_m) {
    for (const LinePart& part : parts)
        for (const double at_m : {part.near_m, part.far_m})
            if (at_m > from_m && at_m < end_m)
                end_m = at_m;
    return end_m;
}

/// Part of [near_m, far_m] in the bounds of the grid's density; near > far where it misses.
[[nodiscard]] inline LinePart clip_to_density(const DensityGrid& grid, const GridLine& line, double near_m,
                                              double far_m) {
    if (grid.is_empty())
        return {1.0, -1.0};
    const Bounds3& box = grid.bounds();
    for (int axis = 0; axis < 3; ++axis) {
        if (line.direction[axis] == 0.0) {
            if (line.origin[axis] < box.min[axis] || line.origin[axis] > box.max[axis])
                return {1.0, -1.0};
            continue;
        }
        const double a = (box.min[axis] - line.origin[axis]) / line.direction[axis];
        const double b = (box.max[axis] - line.origin[axis]) / line.direction[axis];
        near_m = std::max(near_m, std::min(a, b));
        far_m = std::min(far_m, std::max(a, b));
    }
    return {near_m, far_m};
}

/// Steps of a line through the cubes of `side` units: which is next, and where.
class CubeSteps {
public:
    CubeSteps(const GridLine& line, double at_m, int side, const glm::ivec3& first, const glm::ivec3& end)
        : first_(first), end_(end) {
        const glm::dvec3 place = line.at(at_m);
        for (int axis = 0; axis < 3; ++axis) {
            const double direction = line.direction[axis];
            cube_[axis] = std::clamp(static_cast<int>(std::floor(place[axis] / side)), first[axis], end[axis] - 1);
            step_[axis] = direction > 0.0 ? 1 : -1;
            const double face = static_cast<double>(side) * (cube_[axis] + (direction > 0.0 ? 1 : 0));
            next_m_[axis] =
                direction == 0.0 ? std::numeric_limits<double>::infinity() : (face - line.origin[axis]) / direction;
            spacing_m_[axis] = direction == 0.0 ? 0.0 : side / std::abs(direction);
        }
    }
    [[nodiscard]] const glm::ivec3& cube() const { return cube_; }
    [[nodiscard]] double exit_m() const { return std::min({next_m_[0], next_m_[1], next_m_[2]}); }
    /// False: the line has left.
    bool advance() {
        const int axis =
            next_m_[0] <= next_m_[1] ? (next_m_[0] <= next_m_[2] ? 0 : 2) : (next_m_[1] <= next_m_[2] ? 1 : 2);
        cube_[axis] += step_[axis];
        next_m_[axis] += spacing_m_[axis];
        return cube_[axis] >= first_[axis] && cube_[axis] < end_[axis];
    }

private:
    glm::ivec3 first_, end_, cube_{0}, step_{0};
    std::array<double, 3> next_m_{}, spacing_m_{};
};

/// Calls visit(brick, near_m, far_m, brick's place in the table) for each brick with density, near to far, until it
/// returns false.
template <class Visit>
void for_each_brick(const DensityGrid& grid, const GridLine& line, double near_m, double far_m, const Visit& visit) {
    const LinePart part = clip_to_density(grid, line, near_m, far_m);
    if (!(part.near_m < part.far_m))
        return;
    CubeSteps bricks(line, part.near_m, DensityGrid::brick_cells, glm::ivec3(0), grid.table_size());
    for (double at = part.near_m; at < part.far_m;) {
        const double until = std::min(bricks.exit_m(), part.far_m);
        const DensityGrid::Brick* brick = grid.brick(bricks.cube());
        if (brick != nullptr && at < until && !visit(*brick, at, until, bricks.cube()))
            return;
        at = std::max(at, until);
        if (!bricks.advance())
            return;
    }
}

/// Calls visit(const CellSpan<Density>&) for the cells of each brick with density, near to far, until it returns false.
/// Density is what with_density_type() says of the grid.
template <class Density, class Visit>
void for_each_cell(const DensityGrid& grid, const GridLine& line, double near_m, double far_m, const Visit& visit) {
    for_each_brick(
        grid, line, near_m, far_m,
        [&](const DensityGrid::Brick& brick, double from_m, double to_m, const glm::ivec3& place) {
            const GridLine inside{line.origin - double{DensityGrid::brick_cells} * glm::dvec3(place), line.direction};
            CubeSteps cells(inside, from_m, 1, glm::ivec3(0), glm::ivec3(DensityGrid::brick_cells));
            for (double at = from_m; at < to_m;) {
                const double until = std::min(cells.exit_m(), to_m);
                if (at < until) {
                    const CellSpan<Density> span{at, until, cell_corner(brick, cells.cube(), density_stride<Density>),
                                                 vec3(inside.at(at) - glm::dvec3(cells.cube())), vec3(line.direction)};
                    if (!visit(span))
                        return false;
                    at = until;
                }
                if (!cells.advance())
                    break;
            }
            return true;
        });
}

/// Of the densities over [near_m, far_m]: density times metres.
[[nodiscard]] inline glm::dvec4 density_integral(const DensityGrid& grid, const GridLine& line, double near_m,
                                                 double far_m) {
    glm::dvec4 sum(0.0);
    with_density_type(grid, [&]<class Density>(const Density&) {
        for_each_cell<Density>(grid, line, near_m, far_m, [&](const CellSpan<Density>& span) {
            add_integral(sum, span.integral(span.near_m, span.far_m));
            return true;
        });
    });
    return sum;
}
} // namespace tyndall
