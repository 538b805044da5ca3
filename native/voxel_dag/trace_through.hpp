// SPDX-License-Identifier: GPL-3.0-or-later
// One ray through any tree of octants that tree_nodes.hpp, or a layout's own functions of those names, lead down: root_of,
// opened, child_of, leaf_of, groups_of, group_of.
// Based on: Jaspe, dissertation 2018, 5.5.1 and listing 5.7, "transforming the geometry".
// Differs:  as trace.hpp says.
// Bound:    per node on the way 3 multiplications and, per child, one step.
#pragma once
#include "voxel_dag/trace.hpp"
#include "voxel_dag/tree_nodes.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall::voxel_dag {
/// A ray's parameters at planes across the axes.
class ExactPlanes {
public:
    explicit ExactPlanes(const VoxelRay& ray) : origin_(ray.origin) {
        for (int axis = 0; axis < 3; ++axis) {
            inverse_[axis] = 1.0 / ray.direction[axis];
            is_parallel_[axis] = !std::isfinite(inverse_[axis]);
            against_ |= std::uint32_t{!is_parallel_[axis] && inverse_[axis] < 0.0} << axis;
        }
    }
    [[nodiscard]] double at(int axis, double plane) const {
        if (is_parallel_[axis]) // it has passed the planes below it for ever, and the one it lies in
            return plane <= origin_[axis] ? -std::numeric_limits<double>::infinity()
                                          : std::numeric_limits<double>::infinity();
        return (plane - origin_[axis]) * inverse_[axis];
    }
    /// Bit per axis along which the ray goes down.
    [[nodiscard]] std::uint32_t against() const { return against_; }
    /// Where it enters a cube, by its lowest corner, on one axis; and where it leaves.
    [[nodiscard]] double entry(int axis, double lowest, double width) const {
        return at(axis, (against_ >> axis & 1) != 0 ? lowest + width : lowest);
    }
    [[nodiscard]] double exit(int axis, double lowest, double width) const {
        return at(axis, (against_ >> axis & 1) != 0 ? lowest : lowest + width);
    }

private:
    dvec3 origin_, inverse_;
    std::array<bool, 3> is_parallel_;
    std::uint32_t against_ = 0;
};

/// A cube on the way. Its halves are counted along the ray: bit a of `half` is set behind the middle plane of axis a.
template <class Place, class Open>
struct TraceStep {
    std::array<double, 3> middle;
    double end;               ///< Where the ray leaves the cube.
    std::uint32_t half;       ///< The octant at work.
    std::uint32_t child_mask; ///< By stored octants.
    const std::array<std::uint8_t, 8>* stored_octant;
    std::array<std::uint32_t, 3> lowest;
    Place place;
    Open open;
};

template <class Tree>
[[nodiscard]] VoxelHit trace_through(const Tree& dag, const VoxelRay& ray) {
    using Place = decltype(root_of(dag));
    using Open = decltype(opened(dag, 0, root_of(dag)));
    if (dag.is_empty())
        return {};
    const ExactPlanes planes(ray);
    double from = ray.start, end = ray.end;
    for (int axis = 0; axis < 3; ++axis) {
        from = std::max(from, planes.entry(axis, 0.0, static_cast<double>(1u << dag.level)));
        end = std::min(end, planes.exit(axis, 0.0, static_cast<double>(1u << dag.level)));
    }
    const dvec3 sum = ray.origin + ray.direction;
    if (!(from < end) || !std::isfinite(sum.x + sum.y + sum.z))
        return {};
    std::array<TraceStep<Place, Open>, most_level + 1> steps; // by level
    decltype(leaf_of(dag, root_of(dag))) leaf{};
    const auto enter = [&](std::uint32_t level, const std::array<std::uint32_t, 3>& lowest, double until) {
        TraceStep<Place, Open>& step = steps[level];
        step.end = until;
        step.half = 0;
        step.lowest = lowest;
        for (int axis = 0; axis < 3; ++axis) {
            const auto i = static_cast<std::size_t>(axis);
            step.middle[i] = planes.at(axis, static_cast<double>(lowest[i] + (1u << (level - 1))));
            step.half |= std::uint32_t{step.middle[i] <= from} << axis;
        }
    };
    const auto open = [&](std::uint32_t level, const Place& place) {
        TraceStep<Place, Open>& step = steps[level];
        std::uint32_t turn = place.turn;
        if (level > leaf_level) {
            step.place = place;
            step.open = opened(dag, level, place);
            step.child_mask = step.open.child_mask;
        } else {
            leaf = leaf_of(dag, place);
            turn = leaf.turn;
            step.child_mask = groups_of(leaf);
        }
        step.stored_octant = &cube_group.octant[cube_group.product[cube_group.inverse[turn]][planes.against()]];
    };
    std::uint32_t level = dag.level;
    enter(level, {0, 0, 0}, end);
    open(level, root_of(dag));
    while (true) {
        TraceStep<Place, Open>& step = steps[level];
        double until = step.end;
        for (std::size_t axis = 0; axis < 3; ++axis)
            if ((step.half >> axis & 1) == 0)
                until = std::min(until, step.middle[axis]);
        const std::uint32_t octant = (*step.stored_octant)[step.half];
        if ((step.child_mask >> octant & 1) != 0) {
            std::array<std::uint32_t, 3> lowest = step.lowest;
            for (std::uint32_t axis = 0; axis < 3; ++axis)
                lowest[axis] += ((step.half ^ planes.against()) >> axis & 1) << (level - 1);
            if (const double width = static_cast<double>(1u << (level - 1));
                width <= std::max({1.0, ray.width, ray.spread * from})) {
                VoxelHit hit{.distance = from, .voxel = lowest, .axis = 3, .level = level - 1};
                double entry = ray.start;
                for (int axis = 0; axis < 3; ++axis)
                    if (const double at = planes.entry(axis, lowest[static_cast<std::size_t>(axis)], width);
                        at > entry) {
                        entry = at;
                        hit.axis = static_cast<std::uint32_t>(axis);
                    }
                return hit;
            }
            enter(level - 1, lowest, until);
            if (level > leaf_level) {
                open(level - 1, child_of(dag, level, step.place, step.open, octant));
            } else {
                steps[1].child_mask = group_of(leaf, octant);
                steps[1].stored_octant = step.stored_octant;
            }
            --level;
            continue;
        }
        while (until >= steps[level].end) // what the ray leaves with its octant
            if (++level > dag.level)
                return {};
        from = until;
        for (std::size_t axis = 0; axis < 3; ++axis)
            steps[level].half |= std::uint32_t{steps[level].middle[axis] <= from} << axis;
    }
}
} // namespace tyndall::voxel_dag
