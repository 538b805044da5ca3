// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/tile_scan.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "voxel_dag/tile_scan.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tyndall::voxel_dag::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<double, 8>;
using Words = hn::RebindToUnsigned<Tag>;
using Indices = hn::RebindToSigned<Tag>;
static constexpr Tag d;
static constexpr Words words;
static constexpr std::size_t lanes = hn::MaxLanes(d);
using V = hn::Vec<Tag>;
using W = hn::Vec<Words>;

/// One triangle of a block.
class Triangle {
public:
    HWY_INLINE Triangle(const TileLines& block, std::size_t lane) : lines(block), lane_(lane) {}
    HWY_INLINE double one(const Lanes& value) const { return value[lane_]; }
    HWY_INLINE V of(const Lanes& value) const { return hn::Set(d, value[lane_]); }
    HWY_INLINE V at(const Line& line, V x) const { return hn::MulAdd(of(line.slope), x, of(line.offset)); }
    template <std::size_t count>
    HWY_INLINE V lower_bound(const std::array<Line, count>& bounds, V x, V bound) const {
        for (const Line& line : bounds)
            bound = hn::Max(bound, at(line, x));
        return bound;
    }
    template <std::size_t count>
    HWY_INLINE V upper_bound(const std::array<Line, count>& bounds, V x, V bound) const {
        for (const Line& line : bounds)
            bound = hn::Min(bound, at(line, x));
        return bound;
    }

    const TileLines& lines;

private:
    std::size_t lane_;
};
/// Of whole numbers in [0, 2^52).
static HWY_INLINE W as_words(V whole) {
    return hn::Xor(hn::BitCast(words, hn::Add(whole, hn::Set(d, 0x1p52))), hn::BitCast(words, hn::Set(d, 0x1p52)));
}
static HWY_INLINE W place_of(W index, const WordPlace& place) {
    return hn::Or(hn::ShiftLeftSame(hn::And(index, hn::Set(words, 3)), place.low_shift),
                  hn::ShiftLeftSame(hn::ShiftRight<2>(index), place.high_shift));
}

/// Appends what is active in vectors; returns how many there are then. Stores whole vectors.
static HWY_INLINE std::size_t append(W mask, W place, hn::Mask<Words> is_active, std::uint64_t* masks,
                                     std::uint64_t* places, std::size_t count) {
#if HWY_TARGET <= HWY_AVX3
    hn::CompressStore(place, is_active, words, places + count);
    return count + hn::CompressStore(mask, is_active, words, masks + count);
#else // Highway's own is slower there than to append each lane and to count those that stay
    alignas(64) std::uint64_t place_of_lane[lanes], mask_of_lane[lanes];
    std::uint8_t active[8] = {};
    hn::Store(place, words, place_of_lane);
    hn::Store(mask, words, mask_of_lane);
    hn::StoreMaskBits(words, is_active, active);
    for (std::size_t lane = 0; lane < lanes; ++lane) {
        places[count] = place_of_lane[lane];
        masks[count] = mask_of_lane[lane];
        count += active[0] >> lane & 1u;
    }
    return count;
#endif
}

struct WaitingRuns {
    static constexpr std::size_t room = 256;
    alignas(64) std::uint64_t places[room + 2 * lanes], masks[room + 2 * lanes];
};
static HWY_NOINLINE void write(const WaitingRuns& runs, std::size_t count, TileBits& bits) {
    for (std::size_t run = 0; run < count; ++run)
        bits.words[runs.places[run]] |= runs.masks[run];
}

/// Runs that wait to be written: vectors leave what is active in them here, one behind the other.
class Runs {
public:
    HWY_INLINE Runs(WaitingRuns& waiting, TileBits& bits) : waiting_(waiting), bits_(bits) {}
    HWY_INLINE void push(W mask, W place, hn::Mask<Words> is_active) {
        count_ = append(mask, place, is_active, waiting_.masks, waiting_.places, count_);
        if (count_ > WaitingRuns::room)
            write_all();
    }
    HWY_INLINE void write_all() {
        write(waiting_, count_, bits_);
        count_ = 0;
    }

private:
    WaitingRuns& waiting_;
    TileBits& bits_;
    std::size_t count_ = 0; // apart from what is stored through vectors, so that it stays in a register
};

/// Runs that are handed over.
class ListedRuns {
public:
    HWY_INLINE explicit ListedRuns(TriangleRuns& runs) : runs_(runs) {}
    HWY_INLINE void push(W mask, W place, hn::Mask<Words> is_active) {
        count_ = append(mask, place, is_active, runs_.masks.data(), runs_.places.data(), count_);
    }
    [[nodiscard]] HWY_INLINE std::size_t count() const { return count_; }

private:
    TriangleRuns& runs_;
    std::size_t count_ = 0;
};

template <typename Runs>
static HWY_INLINE void scan_one(const Triangle& triangle, const WordPlace& of_row, const WordPlace& of_depth,
                                Runs& runs) {
    const TileLines& lines = triangle.lines;
    const double end = triangle.one(lines.last_row);
    const V last_row = hn::Set(d, end), ones = hn::Set(d, 1.0);
    for (double first_row = triangle.one(lines.first_row); first_row <= end; first_row += static_cast<double>(lanes)) {
        const V row = hn::Add(hn::Set(d, first_row), hn::ConvertTo(d, hn::Iota(Indices(), 0)));
        const V run_from = triangle.lower_bound(lines.run_by_row.lower, row, triangle.of(lines.first_run));
        const V run_to = triangle.upper_bound(lines.run_by_row.upper, row, triangle.of(lines.last_run));
        const V last_depth =
            hn::Floor(triangle.upper_bound(lines.depth_by_row.upper, row, triangle.of(lines.last_depth)));
        V depth = hn::Ceil(triangle.lower_bound(lines.depth_by_row.lower, row, triangle.of(lines.first_depth)));
        const auto is_row = hn::And(hn::Le(row, last_row), hn::Le(hn::Ceil(run_from), run_to));
        const V plane_from = hn::MulAdd(triangle.of(lines.run_from.row_slope), row, triangle.of(lines.run_from.offset));
        const V plane_to = hn::MulAdd(triangle.of(lines.run_to.row_slope), row, triangle.of(lines.run_to.offset));
        const W row_place = place_of(as_words(row), of_row);
        const auto draw = [&](V at_depth, hn::Mask<Tag> is_left) HWY_ATTR {
            V from = hn::MulAdd(triangle.of(lines.run_from.depth_slope), at_depth, plane_from);
            V to = hn::MulAdd(triangle.of(lines.run_to.depth_slope), at_depth, plane_to);
            from = hn::Ceil(triangle.lower_bound(lines.run_by_depth.lower, at_depth, hn::Max(from, run_from)));
            to = hn::Floor(triangle.upper_bound(lines.run_by_depth.upper, at_depth, hn::Min(to, run_to)));
            const W mask =
                hn::And(hn::Shl(hn::Set(words, ~std::uint64_t{0}), as_words(from)),
                        hn::Shr(hn::Set(words, ~std::uint64_t{0}), as_words(hn::Sub(hn::Set(d, tile_side - 1.0), to))));
            const W place = hn::Or(row_place, place_of(as_words(at_depth), of_depth));
            runs.push(mask, place, hn::RebindMask(words, hn::And(is_left, hn::Le(from, to))));
        };
        // Two depths at a time: how many there are is hard to foretell, and each wrong guess costs as much as one.
        for (;;) {
            const auto is_left = hn::And(is_row, hn::Le(depth, last_depth));
            if (hn::AllFalse(d, is_left))
                break;
            draw(depth, is_left);
            depth = hn::Add(depth, ones);
            draw(depth, hn::And(is_row, hn::Le(depth, last_depth)));
            depth = hn::Add(depth, ones);
        }
    }
}

static void scan_all(std::span<const TileLines> blocks, std::size_t count, const ScanAxes& axes, TileBits& bits) {
    WaitingRuns waiting;
    Runs runs(waiting, bits);
    for (std::size_t index = 0; index < count; ++index)
        scan_one(Triangle(blocks[index / block_lanes], index % block_lanes), row_place(axes), depth_place(axes), runs);
    runs.write_all();
}
static void list_one(const TileLines& block, std::size_t lane, const ScanAxes& axes, TriangleRuns& to) {
    ListedRuns runs(to);
    scan_one(Triangle(block, lane), row_place(axes), depth_place(axes), runs);
    to.count = runs.count();
}
} // namespace tyndall::voxel_dag::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>
#include <cmath>

namespace tyndall::voxel_dag {
HWY_EXPORT(scan_all);
void scan(std::span<const TileLines> blocks, std::size_t count, const ScanAxes& axes, TileBits& bits) {
    HWY_DYNAMIC_DISPATCH(scan_all)(blocks, count, axes, bits);
}
HWY_EXPORT(list_one);
void list_runs(const TileLines& block, std::size_t lane, const ScanAxes& axes, TriangleRuns& runs) {
    HWY_DYNAMIC_DISPATCH(list_one)(block, lane, axes, runs);
}

namespace {
/// Indices from `from` to `to`; none where from > to.
struct Interval {
    std::int64_t from, to;
    void keep(const WidePlane::Test& test, std::int64_t row, std::int64_t depth) {
        const Int128 rest = test.row * row + test.depth * depth + test.offset;
        if (test.run > 0)
            from = static_cast<std::int64_t>(std::clamp<Int128>(-floor_of_quotient(rest, test.run), from, tile_side));
        else if (test.run < 0)
            to = static_cast<std::int64_t>(std::clamp<Int128>(floor_of_quotient(rest, -test.run), -1, to));
        else if (rest < 0)
            to = -1;
    }
    void keep(const Line& lower, const Line& upper, std::int64_t by) {
        const auto x = static_cast<double>(by), highest = static_cast<double>(tile_side);
        from = std::max(from, static_cast<std::int64_t>(
                                  std::ceil(std::clamp(lower.slope[0] * x + lower.offset[0], -1.0, highest))));
        to = std::min(
            to, static_cast<std::int64_t>(std::floor(std::clamp(upper.slope[0] * x + upper.offset[0], -1.0, highest))));
    }
    template <std::size_t count>
    void keep(const Bounds<count>& bounds, std::int64_t by) {
        for (std::size_t i = 0; i < count; ++i)
            keep(bounds.lower[i], bounds.upper[i], by);
    }
};
} // namespace

/// use(place, mask) for each run.
template <typename Use>
static void scan_wide(const TileLines& lines, const WidePlane& plane, const ScanAxes& axes, const Use& use) {
    const auto whole = [](const Lanes& first, const Lanes& last) {
        return Interval{static_cast<std::int64_t>(first[0]), static_cast<std::int64_t>(last[0])};
    };
    const Interval rows = whole(lines.first_row, lines.last_row);
    for (std::int64_t row = rows.from; row <= rows.to; ++row) {
        Interval depths = whole(lines.first_depth, lines.last_depth);
        depths.keep(lines.depth_by_row, row);
        for (std::int64_t depth = depths.from; depth <= depths.to; ++depth) {
            Interval run = whole(lines.first_run, lines.last_run);
            run.keep(lines.run_by_row, row);
            run.keep(lines.run_by_depth, depth);
            run.keep(plane.lower, row, depth);
            run.keep(plane.upper, row, depth);
            if (run.from <= run.to)
                use(row_place(axes).of(static_cast<std::uint32_t>(row)) |
                        depth_place(axes).of(static_cast<std::uint32_t>(depth)),
                    ~std::uint64_t{0} << run.from & ~std::uint64_t{0} >> (tile_side - 1 - run.to));
        }
    }
}

void scan(const TileLines& lines, const WidePlane& plane, const ScanAxes& axes, TileBits& bits) {
    scan_wide(lines, plane, axes, [&](std::size_t place, std::uint64_t mask) { bits.words[place] |= mask; });
}
void list_runs(const TileLines& lines, const WidePlane& plane, const ScanAxes& axes, TriangleRuns& runs) {
    runs.count = 0;
    scan_wide(lines, plane, axes, [&](std::size_t place, std::uint64_t mask) {
        runs.places[runs.count] = place;
        runs.masks[runs.count++] = mask;
    });
}
} // namespace tyndall::voxel_dag
#endif
