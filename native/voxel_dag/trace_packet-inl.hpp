// SPDX-License-Identifier: GPL-3.0-or-later
// Eight rays that go nearly the same way through a packed DAG, a lane each, down to cubes where they part; compiled once
// per SIMD target: include after hwy/highway.h, inside foreach_target's passes.
// Based on: Wald et al., Interactive Rendering with Coherent Ray Tracing, Eurographics 2001 (packets).
// Differs:  octants are counted along the rays, whose directions have the same signs: one order is front to back for all.
//           Where few are left, or cubes are small, each goes on alone (trace_walk-inl.hpp), taking turns with the others.
// Bound:    a node's step once for all; per child that is there 7 comparisons of 8 lanes.
#if defined(TYNDALL_TRACE_PACKET_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TYNDALL_TRACE_PACKET_INL
#undef TYNDALL_TRACE_PACKET_INL
#else
#define TYNDALL_TRACE_PACKET_INL
#endif
#include "voxel_dag/trace_walk-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tyndall::voxel_dag::HWY_NAMESPACE {
static constexpr std::size_t packet_size = 8;
static constexpr std::uint32_t packet_level = 5; ///< In cubes of 2^5 and less each ray goes alone.
static constexpr int few_rays = 1;               ///< So many do anywhere.

/// A cube on the way, and the rays' planes there, a lane each.
struct alignas(64) PacketStep {
    double from[packet_size], until[packet_size], middle[3][packet_size];
    double centre[3];
    CursorNode node;
    std::uint32_t left; ///< Octants that are there and were not asked yet.
};

class Packet {
public:
    /// Rays of which each that meets the whole goes down along the same axes, and hits no cube of 2^packet_level or more
    /// whole. False, and nothing happened, where it is not so. receive(i, walk) for those that hit.
    template <class Receive>
    HWY_INLINE bool trace(const TraceTables& tables, std::span<const VoxelRay, packet_size> rays,
                          const Receive& receive) {
        const double side = static_cast<double>(1u << tables.dag->level);
        open_rays_ = 0;
        std::uint32_t against = 0;
        PacketStep& root = steps_[tables.dag->level];
        for (std::uint32_t lane = 0; lane < packet_size; ++lane) {
            RayPlanes& ray = walks_[lane].ray;
            const bool is_open = ray.set(rays[lane], side);
            root.from[lane] = is_open ? ray.from : 1.0;
            root.until[lane] = is_open ? ray.until : 0.0;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                origin_[axis][lane] = ray.origin[axis];
                inverse_[axis][lane] = ray.inverse[axis];
            }
            if (!is_open)
                continue;
            if ((open_rays_ != 0 && ray.against != against) ||
                ray.widest_hit(ray.until) >= static_cast<double>(1u << packet_level))
                return false;
            against = ray.against;
            open_rays_ |= 1u << lane;
        }
        if (open_rays_ == 0)
            return true;
        for (double& centre : root.centre)
            centre = 0.5 * side;
        cursor_.start(tables, against);
        go_through(tables.dag->level, against, receive);
        return true;
    }

private:
    template <class Receive>
    HWY_INLINE void go_through(std::uint32_t root, std::uint32_t against, const Receive& receive) {
        std::uint32_t level = root;
        open(steps_[level]);
        while (open_rays_ != 0) {
            PacketStep& step = steps_[level];
            if (step.left == 0) {
                if (level++ == root)
                    return;
                continue;
            }
            const auto along = static_cast<std::uint32_t>(std::countr_zero(step.left));
            step.left &= step.left - 1;
            PacketStep& child = steps_[level - 1];
            const std::uint32_t meeting = meet(step, along, child) & open_rays_;
            if (meeting == 0)
                continue;
            for (int axis = 0; axis < 3; ++axis)
                child.centre[axis] =
                    step.centre[axis] + static_cast<double>(1u << level) * 0.25 * towards[along ^ against][axis];
            cursor_.go_down(level, step.node, along);
            if (level - 1 <= packet_level || std::popcount(meeting) <= few_rays) {
                go_alone(meeting, child, receive);
            } else {
                --level;
                open(child);
            }
        }
    }
    HWY_INLINE void open(PacketStep& step) const {
        step.left = cursor_.open(step.node);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const V plane = hn::Set(d, step.centre[axis]);
            for (std::size_t first = 0; first < packet_size; first += lanes)
                hn::Store(
                    hn::Mul(hn::Sub(plane, hn::Load(d, origin_[axis] + first)), hn::Load(d, inverse_[axis] + first)), d,
                    step.middle[axis] + first);
        }
    }
    /// The rays that pass an octant, which becomes a step.
    HWY_INLINE std::uint32_t meet(const PacketStep& step, std::uint32_t along, PacketStep& child) const {
        // Behind a plane a ray enters at it, before it leaves at it.
        const double* enters[3];
        const double* leaves[3];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const bool is_behind = (along >> axis & 1) != 0;
            enters[axis] = is_behind ? step.middle[axis] : step.from;
            leaves[axis] = is_behind ? step.until : step.middle[axis];
        }
        std::uint32_t meeting = 0;
        for (std::size_t first = 0; first < packet_size; first += lanes) {
            const auto load = [&](const double* row) HWY_ATTR { return hn::Load(d, row + first); };
            const V from =
                hn::Max(hn::Max(load(enters[0]), load(enters[1])), hn::Max(load(enters[2]), load(step.from)));
            const V until =
                hn::Min(hn::Min(load(leaves[0]), load(leaves[1])), hn::Min(load(leaves[2]), load(step.until)));
            hn::Store(from, d, child.from + first);
            hn::Store(until, d, child.until + first);
            meeting |= bits_of(hn::Lt(from, until)) << first;
        }
        return meeting;
    }
    template <class Receive>
    HWY_INLINE void go_alone(std::uint32_t meeting, const PacketStep& cube, const Receive& receive) {
        for (std::uint32_t left = meeting; left != 0; left &= left - 1) {
            const auto lane = static_cast<std::uint32_t>(std::countr_zero(left));
            walks_[lane].start(cursor_, cube.centre, cube.from[lane], cube.until[lane]);
        }
        while (meeting != 0)
            for (std::uint32_t left = meeting; left != 0; left &= left - 1) {
                const auto lane = static_cast<std::uint32_t>(std::countr_zero(left));
                const Walk::State state = walks_[lane].advance();
                if (state == Walk::State::Goes)
                    continue;
                meeting ^= 1u << lane;
                if (state == Walk::State::Hits) {
                    open_rays_ ^= 1u << lane;
                    receive(lane, walks_[lane]);
                }
            }
    }

    alignas(64) double origin_[3][packet_size], inverse_[3][packet_size];
    PacketStep steps_[most_level + 1];
    Walk walks_[packet_size];
    Cursor cursor_;
    std::uint32_t open_rays_; ///< Bit per ray that has hit nothing.
};
} // namespace tyndall::voxel_dag::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
