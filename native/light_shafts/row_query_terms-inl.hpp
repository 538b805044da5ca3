// SPDX-License-Identifier: GPL-3.0-or-later
// The lit lines of a block for the rays of a packet, a lane each, compiled once per SIMD target: their number, and the
// sum of the terms that they send, which are a geometric series in the line.
// Based on: Abramowitz and Stegun, 22.3 (economised power series).
// Differs:  in thin media a term is a parabola in the line's number, so that one number per ray, with the count and the
//           first two moments of its lit lines side by side, answers all channels. Rays of a packet have almost the same
//           slope: only lines whose own slope lies between theirs are compared ray by ray, 1.4 of a block's 16 in the
//           forest at 2,048 lines; the others are lit for all rays or for none, and looked up.
// Error:    relative 3e-7 of a term at most_thin_gain.
#if defined(TYNDALL_ROW_QUERY_TERMS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TYNDALL_ROW_QUERY_TERMS_INL
#undef TYNDALL_ROW_QUERY_TERMS_INL
#else
#define TYNDALL_ROW_QUERY_TERMS_INL
#endif
#include "light_shafts/row_query_place-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
/// Per line; beyond it, a term at the start of a group of blocks might overflow.
static constexpr float most_packet_gain = 0.15f;
/// Per line; up to it, an exponential is a parabola over the 16 lines of a block: (7.5 gain)^3 / 24 < 3e-7.
static constexpr float most_thin_gain = 2.5e-3f;

/// Count, sum and sum of squares of line numbers side by side: 5, 7 and 11 bits.
static constexpr std::int32_t packed_line(std::int32_t line) { return 1 | line << 5 | line * line << 12; }
/// Of the lines whose bits are set, those of the lower and of the upper half of a block.
struct PackedTable {
    alignas(64) std::int32_t lower[256]{}, upper[256]{}, line[block_lines]{};
    constexpr PackedTable() {
        for (std::int32_t at = 0; at < block_lines; ++at)
            line[at] = packed_line(at);
        for (std::uint32_t bits = 0; bits < 256; ++bits)
            for (std::int32_t at = 0; at < 8; ++at)
                if ((bits >> at & 1) != 0) {
                    lower[bits] += packed_line(at);
                    upper[bits] += packed_line(at + 8);
                }
    }
};
static constexpr PackedTable packed_table;

/// The same up to each line, its own included, of the lower and of the upper half of a block.
struct PackedPrefixes {
    alignas(64) std::int32_t lower[256][8]{}, upper[256][8]{};
    constexpr PackedPrefixes() {
        for (std::uint32_t bits = 0; bits < 256; ++bits) {
            std::int32_t of_lower = 0, of_upper = 0;
            for (std::int32_t line = 0; line < 8; ++line) {
                if ((bits >> line & 1) != 0) {
                    of_lower += packed_line(line);
                    of_upper += packed_line(line + 8);
                }
                lower[bits][line] = of_lower;
                upper[bits][line] = of_upper;
            }
        }
    }
};
static constexpr PackedPrefixes packed_prefixes;

/// Of one channel: the optical depth that a line adds.
template <int channels>
using Gains = V[channels];

/// Terms of thin media.
template <int channels>
class ThinTerms {
public:
    static constexpr float anchor = 0.5f * block_lines; ///< Terms are relative to the middle of a block, in lines.
    static constexpr bool is_finite_anywhere = true;    ///< Also outside of a ray's piece, up to some blocks.
    V block_sum[channels];

    explicit ThinTerms(const Gains<channels>& gain) {
        constexpr float middle = 0.5f * (block_lines - 1);
        for (int c = 0; c < channels; ++c) {
            // exp(-x) = 1 - x + x^2 / 2 - x^3 / 6, and x^3 is 3/4 X^2 x + X^3 / 4 T3(x / X) for |x| <= X.
            const V most = hn::Mul(gain[c], hn::Set(d, middle));
            const V linear = hn::Mul(gain[c], hn::MulAdd(hn::Mul(most, most), hn::Set(d, 0.125f), hn::Set(d, 1.0f)));
            const V square = hn::Mul(hn::Mul(gain[c], gain[c]), hn::Set(d, 0.5f));
            of_count_[c] = hn::MulAdd(square, hn::Set(d, middle * middle),
                                      hn::MulAdd(linear, hn::Set(d, middle), hn::Set(d, 1.0f)));
            of_sum_[c] = hn::NegMulAdd(square, hn::Set(d, 2 * middle), hn::Neg(linear));
            of_squares_[c] = square;
            block_sum[c] = of_moments(c, hn::Set(d, 16.0f), hn::Set(d, 120.0f), hn::Set(d, 1240.0f));
        }
    }
    /// Of a block's terms to those of the block before: exp(-x), its series to x^4: 1e-9 for |x| <= 0.04.
    [[nodiscard]] static HWY_INLINE V block_ratio(V gain) {
        const V x = hn::Mul(gain, hn::Set(d, -float{block_lines}));
        const V p = hn::MulAdd(x, hn::Set(d, 1.0f / 24), hn::Set(d, 1.0f / 6));
        return hn::MulAdd(hn::MulAdd(hn::MulAdd(p, x, hn::Set(d, 0.5f)), x, hn::Set(d, 1.0f)), x, hn::Set(d, 1.0f));
    }
    HWY_INLINE void add_up(const PacketRays& rays, const float* slopes, V (&sum)[channels], V& lines) const {
        const std::uint32_t lit = at_or_above(hn::Set(d, rays.least_slope), slopes);
        const I packed = hn::Set(di, packed_table.lower[lit & 255] + packed_table.upper[lit >> 8]);
        unpack(add_doubtful(packed, lit, rays, slopes, [](int, auto is_lit) { return is_lit; }), sum, lines);
    }
    /// Of each ray only the lines in [begin, past), which are counted from the block's first one.
    HWY_INLINE void add_up_range(const PacketRays& rays, const float* slopes, I begin, I past, V (&sum)[channels],
                                 V& lines) const {
        const std::uint32_t lit = at_or_above(hn::Set(d, rays.least_slope), slopes);
        const auto if_inside = [&](int line, auto is_lit) {
            const auto is_inside = hn::And(hn::Lt(begin, hn::Set(di, line + 1)), hn::Gt(past, hn::Set(di, line)));
            return hn::And(is_lit, is_inside);
        };
        unpack(add_doubtful(packed_between(lit, begin, past), lit, rays, slopes, if_inside), sum, lines);
    }

private:
    /// The lines that are lit for some rays only. No branchless first two: most blocks have none, 1.16 times slower.
    template <class If>
    [[nodiscard]] static HWY_INLINE I add_doubtful(I packed, std::uint32_t all_lit, const PacketRays& rays,
                                                   const float* slopes, const If& if_counted) {
        for (std::uint32_t left = at_or_above(hn::Set(d, rays.most_slope), slopes) & ~all_lit; left != 0;
             left &= left - 1) {
            const int line = __builtin_ctz(left);
            const auto is_lit = hn::RebindMask(di, hn::Ge(rays.slope, hn::Set(d, slopes[line])));
            packed =
                hn::IfThenElse(if_counted(line, is_lit), hn::Add(packed, hn::Set(di, packed_table.line[line])), packed);
        }
        return packed;
    }
    /// Of the lines whose bits are set, those that each ray has in [begin, past).
    [[nodiscard]] static HWY_INLINE I packed_between(std::uint32_t lit, I begin, I past) {
        if constexpr (lanes == block_lines) {
            const hn::Half<decltype(di)> half;
            const std::uint32_t low = lit & 255;
            const auto upper =
                hn::Add(hn::Load(half, packed_prefixes.upper[lit >> 8]), hn::Set(half, packed_prefixes.lower[low][7]));
            const I up_to = hn::Combine(di, upper, hn::Load(half, packed_prefixes.lower[low]));
            const auto before = [&](I line) {
                const I last = hn::Min(hn::Sub(line, hn::Set(di, 1)), hn::Set(di, block_lines - 1));
                const auto is_any = hn::Gt(line, hn::Zero(di));
                const auto at = hn::IndicesFromVec(di, hn::IfThenElseZero(is_any, last));
                return hn::IfThenElseZero(is_any, hn::TableLookupLanes(up_to, at));
            };
            return hn::Sub(before(past), before(begin));
        } else {
            const auto before = [](I line) { // bits of the lines before it
                const I count = hn::Min(hn::Max(line, hn::Zero(di)), hn::Set(di, block_lines));
                return hn::Sub(hn::Shl(hn::Set(di, 1), count), hn::Set(di, 1));
            };
            const I bits =
                hn::And(hn::Set(di, static_cast<std::int32_t>(lit)), hn::AndNot(before(begin), before(past)));
            return hn::Add(hn::GatherIndex(di, packed_table.lower, hn::And(bits, hn::Set(di, 255))),
                           hn::GatherIndex(di, packed_table.upper, hn::ShiftRight<8>(bits)));
        }
    }
    [[nodiscard]] HWY_INLINE V of_moments(int c, V count, V sum, V squares) const {
        return hn::MulAdd(of_squares_[c], squares, hn::MulAdd(of_sum_[c], sum, hn::Mul(of_count_[c], count)));
    }
    HWY_INLINE void unpack(I packed, V (&sum)[channels], V& lines) const {
        lines = hn::ConvertTo(d, hn::And(packed, hn::Set(di, 31)));
        const V first = hn::ConvertTo(d, hn::And(hn::ShiftRight<5>(packed), hn::Set(di, 127))),
                second = hn::ConvertTo(d, hn::ShiftRight<12>(packed));
        for (int c = 0; c < channels; ++c)
            sum[c] = of_moments(c, lines, first, second);
    }
    V of_count_[channels], of_sum_[channels], of_squares_[channels];
};

/// table[n] = q^n.
static HWY_INLINE void fill_powers(V q, V (&table)[block_lines]) {
    table[0] = hn::Set(d, 1.0f);
    table[1] = q;
    for (std::size_t n = 2; n < block_lines; ++n)
        table[n] = hn::Mul(table[n / 2], table[n - n / 2]);
}

/// Terms of any media, from a table.
template <int channels>
class DenseTerms {
public:
    static constexpr float anchor = 0.5f; ///< Terms are relative to the middle of a block's first line.
    static constexpr bool is_finite_anywhere = false;
    V block_sum[channels];

    explicit DenseTerms(const Gains<channels>& gain) {
        for (int c = 0; c < channels; ++c) {
            fill_powers(exp_of(d, hn::Neg(gain[c])), in_block_[c]);
            const V one = in_block_[c][0];
            block_sum[c] = hn::Mul(hn::Mul(hn::Add(one, in_block_[c][1]), hn::Add(one, in_block_[c][2])),
                                   hn::Mul(hn::Add(one, in_block_[c][4]), hn::Add(one, in_block_[c][8])));
        }
    }
    [[nodiscard]] static HWY_INLINE V block_ratio(V gain) {
        return exp_of(d, hn::Mul(gain, hn::Set(d, -float{block_lines})));
    }
    HWY_INLINE void add_up(const PacketRays& rays, const float* slopes, V (&sum)[channels], V& lines) const {
        add_up_if([&](std::size_t line) { return hn::Ge(rays.slope, hn::Set(d, slopes[line])); }, sum, lines);
    }
    /// Of each ray only the lines in [begin, past), which are counted from the block's first one.
    HWY_INLINE void add_up_range(const PacketRays& rays, const float* slopes, I begin, I past, V (&sum)[channels],
                                 V& lines) const {
        add_up_if(
            [&](std::size_t line) {
                const I at = hn::Set(di, static_cast<std::int32_t>(line));
                return hn::And(hn::Ge(rays.slope, hn::Set(d, slopes[line])),
                               hn::RebindMask(d, hn::AndNot(hn::Gt(begin, at), hn::Gt(past, at))));
            },
            sum, lines);
    }

private:
    template <class Lit>
    HWY_INLINE void add_up_if(const Lit& lit, V (&sum)[channels], V& lines) const {
        for (int c = 0; c < channels; ++c)
            sum[c] = hn::Zero(d);
        lines = hn::Zero(d);
        for (std::size_t line = 0; line < block_lines; ++line) {
            const auto is_lit = lit(line);
            lines = hn::IfThenElse(is_lit, hn::Add(lines, hn::Set(d, 1.0f)), lines);
            for (int c = 0; c < channels; ++c)
                sum[c] = hn::IfThenElse(is_lit, hn::Add(sum[c], in_block_[c][line]), sum[c]);
        }
    }
    V in_block_[channels][block_lines]; ///< Powers.
};
} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
