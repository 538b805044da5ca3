// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/beam_start.hpp"
#include "voxel_dag/trace_cursor.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall::voxel_dag {
namespace {
constexpr double infinite = std::numeric_limits<double>::infinity();

/// All rays of a block in one.
struct Beam {
    dvec3 origin, least_inverse, most_inverse;
    std::uint32_t against = 0; ///< Bit per axis along which they go down.
    double end = 0.0;
    double width = 1.0, spread = 0.0; ///< Of the widest cube that any of them hits whole.
    double block_spread = 0.0;        ///< How much wider the block becomes per length.

    /// False: rays that are not alike.
    bool set(std::span<const VoxelRay> block) {
        origin = block[0].origin;
        least_inverse = dvec3(infinite), most_inverse = dvec3(-infinite);
        dvec3 least(infinite), most(-infinite);
        for (const VoxelRay& ray : block) {
            const dvec3 inverse = 1.0 / ray.direction;
            if (ray.origin != origin || !std::isfinite(inverse.x + inverse.y + inverse.z) ||
                !std::isfinite(origin.x + origin.y + origin.z))
                return false;
            least_inverse = glm::min(least_inverse, inverse), most_inverse = glm::max(most_inverse, inverse);
            least = glm::min(least, ray.direction), most = glm::max(most, ray.direction);
            end = std::max(end, ray.end);
            width = std::max(width, ray.width), spread = std::max(spread, ray.spread);
        }
        for (int axis = 0; axis < 3; ++axis) {
            if (least[axis] < 0.0 && most[axis] > 0.0)
                return false;
            against |= std::uint32_t{most[axis] < 0.0} << axis;
            block_spread = std::max(block_spread, most[axis] - least[axis]);
        }
        return true;
    }
    [[nodiscard]] double least_at(int axis, double plane) const {
        const double distance = plane - origin[axis];
        return std::min(distance * least_inverse[axis], distance * most_inverse[axis]);
    }
    [[nodiscard]] double most_at(int axis, double plane) const {
        const double distance = plane - origin[axis];
        return std::max(distance * least_inverse[axis], distance * most_inverse[axis]);
    }
};

/// A cube on the way. Octants are counted along the rays.
struct BeamStep {
    dvec3 centre;
    double from, until; ///< No ray enters before, or leaves behind.
    CursorNode node;
    std::uint32_t left; ///< Octants that are there and were not asked yet.
};
} // namespace

double beam_start(const TraceTables& tables, std::span<const VoxelRay> block) {
    Beam beam;
    if (block.empty() || !beam.set(block))
        return 0.0;
    const std::uint32_t root = tables.dag->level;
    const double side = static_cast<double>(1u << root);
    std::array<BeamStep, most_level + 1> steps; // by level
    steps[root].centre = dvec3(0.5 * side);
    steps[root].from = 0.0, steps[root].until = beam.end;
    for (int axis = 0; axis < 3; ++axis) {
        const bool is_against = (beam.against >> axis & 1) != 0;
        steps[root].from = std::max(steps[root].from, beam.least_at(axis, is_against ? side : 0.0));
        steps[root].until = std::min(steps[root].until, beam.most_at(axis, is_against ? 0.0 : side));
    }
    if (!(steps[root].from < steps[root].until))
        return infinite;
    Cursor cursor;
    cursor.start(tables, beam.against);
    steps[root].left = cursor.open(steps[root].node);
    double nearest = infinite;
    for (std::uint32_t level = root;;) {
        BeamStep& step = steps[level];
        if (step.left == 0) {
            if (level++ == root)
                break;
            continue;
        }
        const auto along = static_cast<std::uint32_t>(std::countr_zero(step.left));
        step.left &= step.left - 1;
        BeamStep& child = steps[level - 1];
        child.from = step.from, child.until = step.until;
        const double width = static_cast<double>(1u << (level - 1));
        for (int axis = 0; axis < 3; ++axis) {
            const bool is_behind = (along >> axis & 1) != 0;
            if (is_behind)
                child.from = std::max(child.from, beam.least_at(axis, step.centre[axis]));
            else
                child.until = std::min(child.until, beam.most_at(axis, step.centre[axis]));
            const bool is_upper = is_behind != ((beam.against >> axis & 1) != 0);
            child.centre[axis] = step.centre[axis] + (is_upper ? 0.5 : -0.5) * width;
        }
        if (!(child.from < child.until) || child.from >= nearest)
            continue;
        if (width <= std::max({beam.width, beam.spread * child.until, beam.block_spread * child.from})) {
            nearest = child.from;
            continue;
        }
        cursor.go_down(level, step.node, along);
        --level;
        child.left = cursor.open(child.node);
    }
    // Before what is hit, not where: what a ray begins in has no face that it entered by.
    return std::max(0.0, std::nextafter(nearest, 0.0));
}
} // namespace tyndall::voxel_dag
