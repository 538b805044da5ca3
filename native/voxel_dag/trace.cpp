// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/trace.hpp"
#include "core/parallel.hpp"
#include "voxel_dag/tracer.hpp"
#include "voxel_dag/tree_nodes.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall::voxel_dag {
namespace {
constexpr double infinite = std::numeric_limits<double>::infinity();

/// A ray's parameters at planes across the axes.
class Planes {
public:
    explicit Planes(const VoxelRay& ray) : origin_(ray.origin) {
        for (int axis = 0; axis < 3; ++axis) {
            inverse_[axis] = 1.0 / ray.direction[axis];
            is_parallel_[axis] = !std::isfinite(inverse_[axis]);
            against_ |= std::uint32_t{!is_parallel_[axis] && inverse_[axis] < 0.0} << axis;
        }
    }
    [[nodiscard]] double at(int axis, double plane) const {
        if (is_parallel_[axis]) // it has passed the planes below it for ever, and the one it lies in
            return plane <= origin_[axis] ? -infinite : infinite;
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
struct Step {
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
VoxelHit trace_through(const Tree& dag, const VoxelRay& ray) {
    using Place = decltype(root_of(dag));
    using Open = decltype(opened(dag, 0, root_of(dag)));
    if (dag.is_empty())
        return {};
    const Planes planes(ray);
    double from = ray.start, end = ray.end;
    for (int axis = 0; axis < 3; ++axis) {
        from = std::max(from, planes.entry(axis, 0.0, static_cast<double>(1u << dag.level)));
        end = std::min(end, planes.exit(axis, 0.0, static_cast<double>(1u << dag.level)));
    }
    const dvec3 sum = ray.origin + ray.direction;
    if (!(from < end) || !std::isfinite(sum.x + sum.y + sum.z))
        return {};
    std::array<Step<Place, Open>, most_level + 1> steps; // by level
    std::uint64_t leaf = 0;
    const auto enter = [&](std::uint32_t level, const std::array<std::uint32_t, 3>& lowest, double until) {
        Step<Place, Open>& step = steps[level];
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
        Step<Place, Open>& step = steps[level];
        std::uint32_t turn = place.turn;
        if (level > leaf_level) {
            step.place = place;
            step.open = opened(dag, level, place);
            step.child_mask = step.open.child_mask;
        } else {
            const TurnedLeaf turned = leaf_of(dag, place);
            leaf = turned.mask;
            turn = turned.turn;
            step.child_mask = occupied_bytes(leaf);
        }
        step.stored_octant = &cube_group.octant[cube_group.product[cube_group.inverse[turn]][planes.against()]];
    };
    std::uint32_t level = dag.level;
    enter(level, {0, 0, 0}, end);
    open(level, root_of(dag));
    while (true) {
        Step<Place, Open>& step = steps[level];
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
                steps[1].child_mask = static_cast<std::uint32_t>(leaf >> 8 * octant & 0xff);
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
} // namespace

VoxelHit trace(const Dag& dag, const VoxelRay& ray) { return trace_through(dag, ray); }
VoxelHit trace(const PackedDag& dag, const VoxelRay& ray) { return trace_through(dag, ray); }
/// A tracer takes as long to make as one ray per 16 shared records of 8^3 takes to follow without.
static bool are_worth_tracer(const PackedDag& dag, std::size_t ray_count) {
    return dag.levels.empty() || ray_count >= directory_step(leaf_level + 1) * dag.levels[0].directory.size() / 16;
}
void trace(const PackedDag& dag, std::span<const VoxelRay> rays, std::span<VoxelHit> hits, const Progress& progress) {
    if (are_worth_tracer(dag, rays.size()))
        return Tracer(dag).trace(rays, hits, progress);
    require(rays.size() == hits.size(), "voxel DAG: ", rays.size(), " rays, but ", hits.size(), " hits");
    parallel_for(rays.size(), progress, [&](std::size_t i) { hits[i] = trace(dag, rays[i]); });
}
void find_occluded(const PackedDag& dag, std::span<const VoxelRay> rays, std::span<bool> are_occluded,
                   const Progress& progress) {
    if (are_worth_tracer(dag, rays.size()))
        return Tracer(dag).find_occluded(rays, are_occluded, progress);
    require(rays.size() == are_occluded.size(), "voxel DAG: ", rays.size(), " rays, but ", are_occluded.size(),
            " answers");
    parallel_for(rays.size(), progress, [&](std::size_t i) { are_occluded[i] = trace(dag, rays[i]).is_hit(); });
}
} // namespace tyndall::voxel_dag
