// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/tile_lines_kernel.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "voxel_dag/tile_lines_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tyndall::voxel_dag::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<double, block_lanes>;
static constexpr Tag d;
static constexpr std::size_t lanes = hn::MaxLanes(d);
using V = hn::Vec<Tag>;
using Mask = hn::Mask<Tag>;

/// One test of tile_lines.hpp: c . index + e >= 0, solved for one index.
struct Solved {
    V slope, offset;
    Mask is_lower, is_upper; ///< Neither: that index is not asked for.
};

/// Lays the lines of some lanes of a block.
class Laying {
public:
    HWY_INLINE Laying(const NearTriangles& triangles, const TileFrame& frame, TileLines& lines, std::size_t first)
        : frame_(frame), lines_(lines), first_(first), half_(hn::Set(d, static_cast<double>(1 << frame.cell_bits) / 2)),
          cells_(hn::Set(d, 1.0 / static_cast<double>(1 << frame.cell_bits))) {
        for (std::size_t corner = 0; corner < 3; ++corner)
            for (std::size_t axis = 0; axis < 3; ++axis)
                at_[corner][axis] = hn::Load(d, triangles.corner[corner][axis].data() + first);
        for (std::size_t edge = 0; edge < 3; ++edge)
            for (std::size_t axis = 0; axis < 3; ++axis)
                along_[edge][axis] = hn::Sub(at_[(edge + 1) % 3][axis], at_[edge][axis]);
    }
    HWY_INLINE void lay() {
        const auto& [run, row, depth] = frame_.axes;
        lay_box(run, lines_.first_run, lines_.last_run);
        lay_box(row, lines_.first_row, lines_.last_row);
        lay_box(depth, lines_.first_depth, lines_.last_depth);
        lay_edges(depth, row, lines_.depth_by_row);
        lay_edges(run, row, lines_.run_by_row);
        lay_edges(run, depth, lines_.run_by_depth);
        lay_plane();
    }

private:
    HWY_INLINE void store(V value, Lanes& to) const { hn::Store(value, d, to.data() + first_); }
    HWY_INLINE void store(V slope, V offset, Line& to) const {
        store(slope, to.slope);
        store(offset, to.offset);
    }
    HWY_INLINE void lay_box(std::size_t axis, Lanes& first, Lanes& last) const {
        const V a = at_[0][axis], b = at_[1][axis], c = at_[2][axis];
        const V least = hn::Min(a, hn::Min(b, c)), most = hn::Max(a, hn::Max(b, c));
        store(hn::Max(hn::Floor(hn::Mul(least, cells_)), hn::Zero(d)), first);
        store(hn::Min(hn::Floor(hn::Mul(most, cells_)), hn::Set(d, static_cast<double>(frame_.last))), last);
    }
    /// e + 0.5, where `lead` is the first component that is not 0.
    HWY_INLINE V offset(V at_centre, V reach, V lead) const {
        const V tie = hn::IfThenElseZero(hn::Gt(lead, hn::Zero(d)), hn::Set(d, 1.0));
        const V steps = hn::Sub(hn::MulAdd(half_, reach, at_centre), tie);
        return hn::Add(hn::Floor(hn::Mul(steps, cells_)), hn::Set(d, 0.5));
    }
    [[nodiscard]] HWY_INLINE bool is_thin() const { return frame_.rule == VoxelizeRule::Thin; }
    HWY_INLINE V or_if_zero(V first, V second) const {
        return hn::IfThenElse(hn::Eq(first, hn::Zero(d)), second, first);
    }

    HWY_INLINE Solved solve_edge(std::size_t edge, std::size_t bounded, std::size_t by, V sign) const {
        const V of_bounded = hn::Mul(hn::Neg(sign), along_[edge][by]), of_by = hn::Mul(sign, along_[edge][bounded]);
        const V a = hn::Abs(of_bounded), b = hn::Abs(of_by);
        const V reach = is_thin() ? hn::Max(a, b) : hn::Add(a, b);
        const V at_centre =
            hn::MulAdd(of_bounded, hn::Sub(half_, at_[edge][bounded]), hn::Mul(of_by, hn::Sub(half_, at_[edge][by])));
        const V lead = bounded < by ? or_if_zero(of_bounded, of_by) : or_if_zero(of_by, of_bounded);
        const V scale = hn::Div(hn::Set(d, -1.0), of_bounded);
        return {.slope = hn::Mul(of_by, scale),
                .offset = hn::Mul(offset(at_centre, reach, lead), scale),
                .is_lower = hn::Gt(of_bounded, hn::Zero(d)),
                .is_upper = hn::Lt(of_bounded, hn::Zero(d))};
    }
    /// The first and the last of the edges that bound from one side; one that does so alone is both.
    template <typename IsOne>
    HWY_INLINE void keep_two(const Solved (&edges)[3], const IsOne& is_one, double none, Line* to) const {
        for (std::size_t which = 0; which < 2; ++which) {
            V slope = hn::Zero(d), bound = hn::Set(d, none);
            for (std::size_t i = 0; i < 3; ++i) { // the last one to be taken stays
                const Solved& edge = edges[which == 0 ? 2 - i : i];
                slope = hn::IfThenElse(is_one(edge), edge.slope, slope);
                bound = hn::IfThenElse(is_one(edge), edge.offset, bound);
            }
            store(slope, bound, to[which]);
        }
    }
    template <std::size_t count>
    HWY_INLINE void lay_edges(std::size_t bounded, std::size_t by, Bounds<count>& bounds) const {
        const V area = hn::Sub(hn::Mul(along_[0][bounded], along_[1][by]), hn::Mul(along_[0][by], along_[1][bounded]));
        const V sign = hn::IfThenElse(hn::Lt(area, hn::Zero(d)), hn::Set(d, -1.0), hn::Set(d, 1.0));
        const Solved edges[3] = {solve_edge(0, bounded, by, sign), solve_edge(1, bounded, by, sign),
                                 solve_edge(2, bounded, by, sign)};
        keep_two(
            edges, [](const Solved& edge) { return edge.is_lower; }, -no_bound, bounds.lower.data());
        keep_two(
            edges, [](const Solved& edge) { return edge.is_upper; }, no_bound, bounds.upper.data());
    }

    HWY_INLINE void lay_plane() {
        V normal[3];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::size_t b = (axis + 1) % 3, c = (axis + 2) % 3;
            normal[axis] = hn::Sub(hn::Mul(along_[0][b], along_[1][c]), hn::Mul(along_[0][c], along_[1][b]));
        }
        V at_centre = hn::Zero(d), reach = hn::Zero(d);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            at_centre = hn::MulAdd(normal[axis], hn::Sub(half_, at_[0][axis]), at_centre);
            reach = is_thin() ? hn::Max(reach, hn::Abs(normal[axis])) : hn::Add(reach, hn::Abs(normal[axis]));
        }
        const V lead = or_if_zero(normal[0], or_if_zero(normal[1], normal[2]));
        const V above = offset(at_centre, reach, lead), below = offset(hn::Neg(at_centre), reach, hn::Neg(lead));
        const auto& [run, row, depth] = frame_.axes;
        const Mask has_run = hn::Ne(normal[run], hn::Zero(d)), has_depth = hn::Ne(normal[depth], hn::Zero(d));

        const V by_run = hn::Div(hn::Set(d, -1.0), normal[run]);
        const V row_slope = hn::IfThenElseZero(has_run, hn::Mul(normal[row], by_run));
        const V depth_slope = hn::IfThenElseZero(has_run, hn::Mul(normal[depth], by_run));
        for (PlaneLine* const line : {&lines_.run_from, &lines_.run_to}) {
            store(row_slope, line->row_slope);
            store(depth_slope, line->depth_slope);
        }
        store_pair(above, below, by_run, has_run, lines_.run_from.offset, lines_.run_to.offset);

        // Where runs lie within the plane, it bounds their depth.
        const V by_depth = hn::Div(hn::Set(d, -1.0), normal[depth]);
        const Mask bounds_depth = hn::AndNot(has_run, has_depth);
        Line &lower = lines_.depth_by_row.lower[2], &upper = lines_.depth_by_row.upper[2];
        const V slope = hn::IfThenElseZero(bounds_depth, hn::Mul(normal[row], by_depth));
        store(slope, lower.slope);
        store(slope, upper.slope);
        store_pair(above, below, by_depth, bounds_depth, lower.offset, upper.offset);
    }
    /// The offsets of both tests of the plane, which bound from below where the scale, -1 / component, is negative.
    HWY_INLINE void store_pair(V above, V below, V scale, Mask is_bound, Lanes& lower, Lanes& upper) const {
        const Mask is_above_lower = hn::Lt(scale, hn::Zero(d));
        const V a = hn::Mul(above, scale), b = hn::Mul(below, hn::Neg(scale));
        store(hn::IfThenElse(is_bound, hn::IfThenElse(is_above_lower, a, b), hn::Set(d, -no_bound)), lower);
        store(hn::IfThenElse(is_bound, hn::IfThenElse(is_above_lower, b, a), hn::Set(d, no_bound)), upper);
    }

    const TileFrame& frame_;
    TileLines& lines_;
    std::size_t first_;
    V half_, cells_;
    V at_[3][3], along_[3][3];
};

static void lay_blocks(std::span<const NearTriangles> blocks, const TileFrame& frame, std::span<TileLines> lines) {
    for (std::size_t block = 0; block < blocks.size(); ++block)
        for (std::size_t first = 0; first < block_lanes; first += lanes)
            Laying(blocks[block], frame, lines[block], first).lay();
}

static void sum_seen(std::span<const NearTriangles> blocks, std::array<double, 3>& seen) {
    V sums[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
    for (const NearTriangles& block : blocks)
        for (std::size_t first = 0; first < block_lanes; first += lanes) {
            V along[2][3];
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const V origin = hn::Load(d, block.corner[0][axis].data() + first);
                for (std::size_t i = 0; i < 2; ++i)
                    along[i][axis] = hn::Sub(hn::Load(d, block.corner[i + 1][axis].data() + first), origin);
            }
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const std::size_t b = (axis + 1) % 3, c = (axis + 2) % 3;
                sums[axis] = hn::Add(
                    sums[axis], hn::Abs(hn::Sub(hn::Mul(along[0][b], along[1][c]), hn::Mul(along[0][c], along[1][b]))));
            }
        }
    for (std::size_t axis = 0; axis < 3; ++axis)
        seen[axis] = hn::GetLane(hn::SumOfLanes(d, sums[axis]));
}
} // namespace tyndall::voxel_dag::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::voxel_dag {
HWY_EXPORT(lay_blocks);
HWY_EXPORT(sum_seen);
std::array<double, 3> seen_along_axes(std::span<const NearTriangles> blocks) {
    std::array<double, 3> seen;
    HWY_DYNAMIC_DISPATCH(sum_seen)(blocks, seen);
    return seen;
}
void lay_near_lines(std::span<const NearTriangles> blocks, const TileFrame& frame, std::span<TileLines> lines) {
    HWY_DYNAMIC_DISPATCH(lay_blocks)(blocks, frame, lines);
}
} // namespace tyndall::voxel_dag
#endif
