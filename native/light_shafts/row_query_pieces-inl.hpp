// SPDX-License-Identifier: GPL-3.0-or-later
// Pieces of view rays in columns, compiled once per SIMD target: all that the sum over lit lines needs of a piece, on
// whole vectors of pieces.
#if defined(TYNDALL_ROW_QUERY_PIECES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TYNDALL_ROW_QUERY_PIECES_INL
#undef TYNDALL_ROW_QUERY_PIECES_INL
#else
#define TYNDALL_ROW_QUERY_PIECES_INL
#endif
#include "light_shafts/exp-inl.hpp"
#include "light_shafts/row_query_lane-inl.hpp"
#include <array>

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
using V = hn::Vec<LineTag>;
static constexpr LineTag d;
static constexpr hn::RebindToSigned<LineTag> di;
static constexpr std::size_t lanes = hn::MaxLanes(d), parts = block_lines / lanes;
static constexpr std::int32_t blocks_per_word = 64; ///< A bit each.

/// q, q^2, q^4 and q^8.
struct Powers {
    float one, two, four, eight;
};
/// sinh(x) / x, the mean of an exponential over a stretch around its middle; 1e-6 up to 1.5.
static HWY_INLINE V mean_around_middle(V x) {
    const V z = hn::Mul(x, x);
    V p = hn::MulAdd(z, hn::Set(d, 1.0f / 362880), hn::Set(d, 1.0f / 5040));
    p = hn::MulAdd(p, z, hn::Set(d, 1.0f / 120));
    p = hn::MulAdd(p, z, hn::Set(d, 1.0f / 6));
    return hn::MulAdd(p, z, hn::Set(d, 1.0f));
}

static HWY_INLINE V clamped(V value, V low, V high) { return hn::Min(hn::Max(value, low), high); }

/// Rays in their rows, a lane each.
struct RaysInRow {
    V near_m, near_index; ///< near_index: of near_m, in lines.
    V step, lines_per_m;  ///< Along the ray: metres per line, and 1 / step.
    V first_line, last_line;
    [[nodiscard]] HWY_INLINE V distance_at(V index) const {
        return hn::MulAdd(hn::Sub(index, near_index), step, near_m);
    }
};
/// One piece of each ray: whole lines of the row, and what is left over at both ends, metres.
struct PieceInRow {
    V whole_begin, whole_past; ///< Lines; the same where none is whole.
    V begin_middle, begin_length, end_middle, end_length;

    HWY_INLINE void place(const RaysInRow& rays, V begin, V end) {
        const V one = hn::Set(d, 1.0f), half = hn::Set(d, 0.5f);
        const V past = hn::Add(rays.last_line, one);
        const auto index_at = [&](V t) {
            return hn::MulAdd(hn::Sub(t, rays.near_m), rays.lines_per_m, rays.near_index);
        };
        whole_begin = clamped(hn::Ceil(index_at(begin)), rays.first_line, past);
        whole_past = clamped(hn::Floor(index_at(end)), rays.first_line, past);
        const V left = clamped(rays.distance_at(whole_begin), begin, end);
        const V right = hn::Max(clamped(rays.distance_at(whole_past), begin, end), left);
        begin_length = hn::Sub(left, begin);
        end_length = hn::Sub(end, right);
        begin_middle = hn::MulAdd(half, begin_length, begin);
        end_middle = hn::NegMulAdd(half, end_length, end);
    }
    /// The line that what is left over belongs to.
    [[nodiscard]] HWY_INLINE V line_before(const RaysInRow& rays) const {
        return clamped(hn::Sub(whole_begin, hn::Set(d, 1.0f)), rays.first_line, rays.last_line);
    }
    [[nodiscard]] HWY_INLINE V line_after(const RaysInRow& rays) const {
        return clamped(whole_past, rays.first_line, rays.last_line);
    }
};

/// Pieces of some rays in columns, so that all but the sum over lines runs on whole vectors of pieces.
struct PieceBatch {
    static constexpr std::size_t capacity = 256;
    template <class Value>
    using Column = std::array<Value, capacity>;

    // In: the ray in its row, and the piece.
    alignas(64) Column<float> near_index, ray_near_m, m_per_line, first_line, last_line, row_start;
    alignas(64) Column<float> piece_near_m, begin_m, end_m; // the piece's own near, and its part within the ray
    alignas(64) std::array<Column<float>, 3> source_per_m, depth_at_near, depth_per_m;
    Column<std::uint32_t> ray;
    Column<std::int32_t> slice;
    Column<float> slope;
    std::size_t count = 0;

    // Out: whole lines [first, end), the lines that what is left over at both ends belongs to, and what each sends.
    alignas(64) Column<std::int32_t> whole_first, whole_end, line_before, line_after;
    alignas(64) std::array<Column<float>, 3> of_group, block_sum, last_block, per_line, at_begin, at_end;
    alignas(64) std::array<std::array<Column<float>, 4>, 3> of_line, of_block; // Powers
    alignas(64) Column<float> begin_length_m, end_length_m, is_steep, is_grey;

    void evaluate();
    [[nodiscard]] static Powers powers(const std::array<Column<float>, 4>& columns, std::size_t i) {
        return {columns[0][i], columns[1][i], columns[2][i], columns[3][i]};
    }
};

HWY_INLINE void PieceBatch::evaluate() {
    const V one = hn::Set(d, 1.0f), half = hn::Set(d, 0.5f);
    for (std::size_t i = 0; i < count; i += lanes) {
        const auto in = [&](const Column<float>& column) { return hn::Load(d, &column[i]); };
        const V step = in(m_per_line), own_near = in(piece_near_m);
        const RaysInRow rays{in(ray_near_m), in(near_index), step, hn::Div(one, step), in(first_line), in(last_line)};
        PieceInRow piece;
        piece.place(rays, in(begin_m), in(end_m));
        const V in_row = hn::Sub(piece.whole_begin, in(row_start));
        const V block_line = hn::MulAdd(hn::Floor(hn::Mul(in_row, hn::Set(d, 1.0f / block_lines))),
                                        hn::Set(d, float{block_lines}), in(row_start));
        const V lines_before_last = hn::Mul(
            hn::Floor(hn::Mul(hn::Sub(hn::Sub(piece.whole_past, one), block_line), hn::Set(d, 1.0f / block_lines))),
            hn::Set(d, float{block_lines}));
        const V block_middle = hn::MulAdd(half, step, rays.distance_at(block_line));
        hn::Store(piece.begin_length, d, &begin_length_m[i]);
        hn::Store(piece.end_length, d, &end_length_m[i]);
        hn::Store(hn::ConvertTo(di, piece.whole_begin), di, &whole_first[i]);
        hn::Store(hn::ConvertTo(di, piece.whole_past), di, &whole_end[i]);
        hn::Store(hn::ConvertTo(di, piece.line_before(rays)), di, &line_before[i]);
        hn::Store(hn::ConvertTo(di, piece.line_after(rays)), di, &line_after[i]);
        const auto same_as_red = [&](std::size_t c) {
            return hn::And(hn::Eq(in(depth_per_m[c]), in(depth_per_m[0])),
                           hn::Eq(in(depth_at_near[c]), in(depth_at_near[0])));
        };
        const auto is_same = hn::And(same_as_red(1), same_as_red(2));
        hn::Store(hn::IfThenElseZero(is_same, one), d, &is_grey[i]);
        const auto differs = hn::Not(hn::And(is_same, hn::Gt(in(source_per_m[0]), hn::Set(d, 1e-30f))));
        // Of pieces alone: what an earlier call left behind them must not decide.
        const bool shares_red = hn::AllFalse(d, hn::And(differs, hn::FirstN(d, std::min(lanes, count - i))));
        const V line_count = hn::Sub(hn::Add(rays.last_line, one), rays.first_line);
        V steep = hn::Zero(d);
        for (std::size_t c = 0; c < 3; ++c) {
            const V source = in(source_per_m[c]), at_near = in(depth_at_near[c]), slope_c = in(depth_per_m[c]);
            if (c > 0 && shares_red) { // as red, but for the source
                const V ratio = hn::Div(source, in(source_per_m[0]));
                for (auto* columns : {&per_line, &at_begin, &at_end})
                    hn::Store(hn::Mul(in((*columns)[0]), ratio), d, &(*columns)[c][i]);
                continue;
            }
            const V line_gain = hn::Mul(slope_c, step);
            const auto mean_at = [&](V middle, V length) { // of the transmittance over a stretch, times its length
                const V depth = hn::MulAdd(slope_c, hn::Sub(middle, own_near), at_near);
                return hn::Mul(
                    hn::Mul(source, length),
                    hn::Mul(exp_of(d, hn::Neg(depth)), mean_around_middle(hn::Mul(half, hn::Mul(slope_c, length)))));
            };
            const auto store_powers = [&](V q, std::array<Column<float>, 4>& columns) {
                V sum = one; // of q^0 .. q^15
                for (Column<float>& column : columns) {
                    hn::Store(q, d, &column[i]);
                    sum = hn::MulAdd(sum, q, sum);
                    q = hn::Mul(q, q);
                }
                return sum;
            };
            hn::Store(store_powers(exp_of(d, hn::Neg(line_gain)), of_line[c]), d, &block_sum[c][i]);
            store_powers(exp_of(d, hn::Mul(line_gain, hn::Set(d, -16.0f))), of_block[c]);
            hn::Store(exp_of(d, hn::Mul(line_gain, hn::Set(d, -256.0f))), d, &of_group[c][i]);
            hn::Store(exp_of(d, hn::Neg(hn::Mul(line_gain, lines_before_last))), d, &last_block[c][i]);
            hn::Store(mean_at(block_middle, step), d, &per_line[c][i]);
            hn::Store(mean_at(piece.begin_middle, piece.begin_length), d, &at_begin[c][i]);
            hn::Store(mean_at(piece.end_middle, piece.end_length), d, &at_end[c][i]);
            const auto overflows = hn::Or(hn::Gt(hn::Abs(line_gain), hn::Set(d, 2.0f)),
                                          hn::Lt(hn::Mul(line_gain, line_count), hn::Set(d, -40.0f)));
            steep = hn::IfThenElse(overflows, one, steep);
        }
        hn::Store(steep, d, &is_steep[i]);
    }
}

} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
