// SPDX-License-Identifier: GPL-3.0-or-later
// One ray's way through a packed DAG, the octants of a cube side by side in the lanes of a vector; compiled once per SIMD
// target: include after hwy/highway.h, inside foreach_target's passes.
// Based on: trace.hpp's planes; Laine and Karras, Efficient Sparse Voxel Octrees, 2010: octants by the direction's signs.
// Differs:  no step from octant to octant. All 8 intervals at once give a mask of those that the ray passes; ANDed with
//           the children that are there, its bits come in the order of the ray. What is not there costs nothing.
// Bound:    per node that is entered 3 multiplications, 6 comparisons of 8 lanes, and the cursor's step.
#if defined(TYNDALL_TRACE_WALK_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TYNDALL_TRACE_WALK_INL
#undef TYNDALL_TRACE_WALK_INL
#else
#define TYNDALL_TRACE_WALK_INL
#endif
#include "voxel_dag/cover_run.hpp"
#include "voxel_dag/node_shares.hpp"
#include "voxel_dag/trace.hpp"
#include <cmath>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tyndall::voxel_dag::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<double, 8>;
static constexpr Tag d;
static constexpr std::size_t lanes = hn::MaxLanes(d);
using V = hn::Vec<Tag>;

/// The bits of a mask's lanes.
HWY_INLINE std::uint32_t bits_of(hn::Mask<Tag> mask) {
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, mask, bits);
    return bits[0];
}

/// The centre of an octant of the world lies a quarter of the cube's width towards these.
static constexpr double towards[8][3] = {{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {1, 1, -1},
                                         {-1, -1, 1},  {1, -1, 1},  {-1, 1, 1},  {1, 1, 1}};

/// A ray as it meets planes.
struct RayPlanes {
    double origin[3], inverse[3];
    std::uint32_t against = 0; ///< Bit per axis along which it goes down.
    double from, until;        ///< Where it enters the whole, and leaves it.
    double width, spread, start;
    const NodeShares* shares; ///< Null: all cubes that are not looked into are hit.
    CoverRun run;             ///< Through those that are partly filled.

    /// False: it misses the whole, or is not finite.
    HWY_INLINE bool set(const VoxelRay& ray, double side) {
        against = 0;
        from = start = ray.start, until = ray.end;
        for (int axis = 0; axis < 3; ++axis) {
            origin[axis] = ray.origin[axis];
            inverse[axis] = 1.0 / ray.direction[axis];
            if (!std::isfinite(inverse[axis])) {
                // It has passed the planes below it for ever, and the one it lies in: infinite times what is never 0.
                origin[axis] = std::floor(origin[axis]) + 0.5;
                inverse[axis] = std::numeric_limits<double>::infinity();
            }
            const bool is_against = inverse[axis] < 0.0;
            against |= std::uint32_t{is_against} << axis;
            from = std::max(from, at(axis, is_against ? side : 0.0));
            until = std::min(until, at(axis, is_against ? 0.0 : side));
        }
        width = std::max(1.0, ray.width);
        spread = ray.spread;
        shares = ray.shares;
        run.start(ray.number, ray.asks_voxels_of_sheets);
        const dvec3 sum = ray.origin + ray.direction;
        return from < until && std::isfinite(sum.x + sum.y + sum.z);
    }
    [[nodiscard]] HWY_INLINE double at(int axis, double plane) const { return (plane - origin[axis]) * inverse[axis]; }
    /// Cubes that begin there and are no wider are hit whole.
    [[nodiscard]] HWY_INLINE double widest_hit(double distance) const {
        const double widest = std::max(width, spread * distance);
        // Nothing is known of what cubes of two voxels cover: those are nearly there.
        return shares != nullptr && widest < 4.0 ? 1.0 : widest;
    }
};

/// A cube on the way. Octants are counted along the ray.
struct alignas(64) WalkStep {
    double from[8], until[8]; ///< Where the ray enters the octants, and leaves them.
    double centre[3];
    CursorNode node;
    std::uint32_t left; ///< Octants on the way that are there and were not asked yet.
};

/// One ray's way down and up.
class Walk {
public:
    RayPlanes ray;

    /// In a cube, before the first advance().
    HWY_INLINE void start(const Cursor& cursor, const double* centre, double from, double until) {
        cursor_ = cursor;
        level_ = cursor.level();
        left_levels_ = 0;
        has_found_ = false;
        WalkStep& step = steps_[level_];
        for (int axis = 0; axis < 3; ++axis)
            step.centre[axis] = centre[axis];
        cross(step, from, until);
    }

    enum class State : std::uint8_t { Goes, Hits, Misses };
    /// Opens the cube that was reached, and goes to the next one.
    HWY_INLINE State advance() {
        WalkStep* step = &steps_[level_];
        step->left &= cursor_.open(step->node);
        left_levels_ |= std::uint32_t{step->left != 0} << level_;
        while (left_levels_ != 0) {
            level_ = static_cast<std::uint32_t>(std::countr_zero(left_levels_));
            step = &steps_[level_];
            const auto along = static_cast<std::uint32_t>(std::countr_zero(step->left));
            step->left &= step->left - 1;
            left_levels_ ^= std::uint32_t{step->left == 0} << level_;
            from_ = step->from[along];
            world_ = along ^ ray.against;
            half_ = static_cast<double>(1u << (level_ - 1));
            if (ray.shares != nullptr && ray.run.is_unsure(from_) && stops_at_voxel())
                return State::Hits;
            // A brick that was looked into is looked into down to its voxels, however wide a cone is farther on.
            if (half_ <= ray.widest_hit(from_) && (ray.shares == nullptr || half_ != 2.0)) {
                if (half_ == 1.0 || ray.shares == nullptr || stops_in(*step, along))
                    return State::Hits;
                continue;
            }
            WalkStep& child = steps_[level_ - 1];
            for (int axis = 0; axis < 3; ++axis)
                child.centre[axis] = step->centre[axis] + 0.5 * half_ * towards[world_][axis];
            cross(child, from_, step->until[along]);
            cursor_.go_down(level_, step->node, along);
            --level_;
            return State::Goes;
        }
        const bool is_unsure = ray.shares != nullptr && ray.run.is_unsure(std::numeric_limits<double>::infinity());
        return is_unsure && stops_at_voxel() ? State::Hits : State::Misses;
    }

    /// After State::Hits.
    HWY_INLINE VoxelHit hit() const {
        if (has_found_)
            return found_;
        VoxelHit found{.distance = from_ + 0.0, .voxel = {}, .axis = 3, .level = level_ - 1}; // -0 becomes 0
        double entry = ray.start;
        for (std::uint32_t axis = 0; axis < 3; ++axis) {
            const double lowest = steps_[level_].centre[axis] - ((world_ >> axis & 1) != 0 ? 0.0 : half_);
            found.voxel[axis] = static_cast<std::uint32_t>(lowest);
            const double at = ray.at(static_cast<int>(axis), (ray.against >> axis & 1) != 0 ? lowest + half_ : lowest);
            if (at > entry) {
                entry = at;
                found.axis = axis;
            }
        }
        if (ray.run.axis() != CoverRun::no_axis) {
            found.distance = ray.run.distance();
            found.axis = ray.run.axis();
        }
        return found;
    }

private:
    /// Whether the ray stops in a cube that is not looked into.
    HWY_INLINE bool stops_in(const WalkStep& step, std::uint32_t along) {
        cursor_.go_down(level_, step.node, along);
        std::array<double, 3> widths;
        for (std::size_t axis = 0; axis < 3; ++axis)
            widths[axis] = (step.until[along] - step.from[along]) / (half_ * std::abs(ray.inverse[axis]));
        return ray.run.stops(step.from[along], step.until[along], widths, ray.shares->of(*cursor_.tables(), cursor_));
    }
    /// Whether voxels stop it where cubes left that open (cover_run.hpp).
    HWY_NOINLINE bool stops_at_voxel() {
        Walk among_voxels;
        among_voxels.ray = ray;
        among_voxels.ray.shares = nullptr;
        among_voxels.ray.width = 1.0, among_voxels.ray.spread = 0.0;
        const std::uint32_t root = cursor_.tables()->dag->level;
        const double middle = 0.5 * static_cast<double>(1u << root), centre[3] = {middle, middle, middle};
        Cursor cursor;
        cursor.start(*cursor_.tables(), ray.against);
        among_voxels.start(cursor, centre, ray.run.unsure_from(), ray.run.unsure_until());
        State state;
        do
            state = among_voxels.advance();
        while (state == State::Goes);
        ray.run.pass();
        has_found_ = state == State::Hits;
        if (has_found_)
            found_ = among_voxels.hit();
        return has_found_;
    }
    /// The octants' intervals, and which of them the ray passes.
    HWY_INLINE void cross(WalkStep& step, double from, double until) const {
        const V x = hn::Set(d, ray.at(0, step.centre[0])), y = hn::Set(d, ray.at(1, step.centre[1])),
                z = hn::Set(d, ray.at(2, step.centre[2])), begin = hn::Set(d, from), end = hn::Set(d, until);
        step.left = 0;
        for (std::size_t first = 0; first < 8; first += lanes) {
            const auto is_behind = [&](std::size_t bit) HWY_ATTR {
                alignas(64) double behind[lanes];
                for (std::size_t lane = 0; lane < lanes; ++lane)
                    behind[lane] = ((first + lane) & bit) != 0 ? 1.0 : 0.0;
                return hn::Ne(hn::Load(d, behind), hn::Zero(d));
            };
            const auto is_x = is_behind(1), is_y = is_behind(2), is_z = is_behind(4);
            const V enters = hn::Max(hn::Max(hn::IfThenElse(is_x, x, begin), hn::IfThenElse(is_y, y, begin)),
                                     hn::Max(hn::IfThenElse(is_z, z, begin), begin));
            const V leaves = hn::Min(hn::Min(hn::IfThenElse(is_x, end, x), hn::IfThenElse(is_y, end, y)),
                                     hn::Min(hn::IfThenElse(is_z, end, z), end));
            hn::Store(enters, d, step.from + first);
            hn::Store(leaves, d, step.until + first);
            step.left |= bits_of(hn::Lt(enters, leaves)) << first;
        }
    }

    Cursor cursor_;       ///< At the cube that is opened next.
    double from_, half_;  ///< Of the octant that was reached: the ray's way to it, and its width.
    std::uint32_t world_; ///< That octant, in the world.
    std::uint32_t level_;
    std::uint32_t left_levels_; ///< Bit per level whose cube has octants left.
    bool has_found_;            ///< What was hit was found among voxels.
    VoxelHit found_;
    WalkStep steps_[most_level + 1];
};
} // namespace tyndall::voxel_dag::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
