// SPDX-License-Identifier: GPL-3.0-or-later
// Rays of one slice side by side, a lane each, compiled once per SIMD target. Neighbours of a picture that share a row
// have almost the same slope: a block of 16 lines is wholly lit or dark for all of them together, and a line of a block
// that is not costs one compare and one masked addition per channel for all of them.
// Based on: Wald et al., Interactive Rendering with Coherent Ray Tracing, Eurographics 2001 (packets).
// Differs:  no traversal; per piece a table of the series' 16 terms within a block, and one of 16 blocks.
// Bound:    full HD, forest at 2,048 lines: per packet of 16 rays 17 mixed blocks * 16 * (1 + channels) operations, and
//           about as many for all else; 4 bytes per line and packet, from the first-level cache.
#if defined(TYNDALL_ROW_QUERY_PACKET_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TYNDALL_ROW_QUERY_PACKET_INL
#undef TYNDALL_ROW_QUERY_PACKET_INL
#else
#define TYNDALL_ROW_QUERY_PACKET_INL
#endif
#include "light_shafts/row_query_asked-inl.hpp"
#include "light_shafts/row_query_pieces-inl.hpp"
#include <bit>

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
using LaneMask = hn::Mask<LineTag>;
using I = hn::Vec<decltype(di)>;

/// Per line; beyond it, a term at the start of a group of blocks might overflow.
static constexpr float most_packet_gain = 0.15f;
/// Fewer rays that share a row are cheaper one by one.
static constexpr std::size_t least_packet = std::max<std::size_t>(2, lanes / 4);

static HWY_INLINE float least_of(V v) { return hn::GetLane(hn::MinOfLanes(d, v)); }
static HWY_INLINE float most_of(V v) { return hn::GetLane(hn::MaxOfLanes(d, v)); }
static HWY_INLINE V clamped(V value, V low, V high) { return hn::Min(hn::Max(value, low), high); }

/// table[n] = q^n.
static HWY_INLINE void fill_powers(V q, V (&table)[block_lines]) {
    table[0] = hn::Set(d, 1.0f);
    table[1] = q;
    for (std::size_t n = 2; n < block_lines; ++n)
        table[n] = hn::Mul(table[n / 2], table[n - n / 2]);
}

/// Blocks of a row as all rays of a packet see them, a bit each, counted from `first`.
struct PacketBlocks {
    static constexpr std::size_t most_words = 65; // 65536 lines and the margins
    std::int32_t first, end;
    std::array<std::uint64_t, most_words> all_lit, some_lit;

    /// Whether any line may be lit for any slope between the two.
    bool find(const RowView& row, float least_slope, float most_slope, std::int32_t first_line,
              std::int32_t last_line) {
        first = (first_line - row.first) / block_lines;
        end = (last_line - row.first) / block_lines + 1;
        const V least = hn::Set(d, least_slope), most = hn::Set(d, most_slope);
        std::uint64_t any = 0;
        for (std::int32_t start = first, word = 0; start < end; start += blocks_per_word, ++word) {
            std::uint64_t lit = 0, some = 0;
            for (std::int32_t group = 0; group < std::min(blocks_per_word, end - start); group += block_lines) {
                lit |= std::uint64_t{at_or_above(least, row.highest + start + group)} << group;
                some |= std::uint64_t{at_or_above(most, row.lowest + start + group)} << group;
            }
            some &= bits_between(first, end, start);
            all_lit[static_cast<std::size_t>(word)] = lit & some;
            some_lit[static_cast<std::size_t>(word)] = some;
            any |= some;
        }
        return any != 0;
    }
    /// Of the 64 blocks from `start` on, those in [begin, past).
    static std::uint64_t bits_between(std::int32_t begin, std::int32_t past, std::int32_t start) {
        const auto below = [&](std::int32_t block) { // bits of blocks before it
            const std::int32_t count = std::clamp(block - start, 0, blocks_per_word);
            return count == blocks_per_word ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
        };
        return below(past) & ~below(begin);
    }
};

/// What the rays of a packet are, a lane each.
struct PacketRays {
    RowView row;
    V slope, near_m, far_m, near_index, step, first_line, last_line;
    I first_piece, piece_count;
    PacketBlocks blocks;
};

/// One piece of each ray: where it lies in the row.
struct PacketPiece {
    LaneMask is_here, has_whole;
    V near_m;                                             ///< Its own, which depths are counted from.
    V whole_begin, whole_past;                            ///< Whole lines; the same where there are none.
    V begin_middle, begin_length, end_middle, end_length; ///< What is left over at both ends, metres.
    LaneMask begin_lit, end_lit;
    std::int32_t outer_begin, outer_end; ///< Blocks that any ray has lines of.
    std::int32_t inner_begin, inner_end; ///< Blocks that all rays have all lines of.
};

/// Nothing is known of the medium yet: most pieces end here, in the dark.
static HWY_INLINE bool place_piece(const PacketRays& rays, V piece_near, V piece_far, LaneMask has_piece,
                                   PacketPiece& piece) {
    const V one = hn::Set(d, 1.0f), half = hn::Set(d, 0.5f);
    const V begin = hn::Max(piece_near, rays.near_m), end = hn::Min(piece_far, rays.far_m);
    piece.is_here = hn::And(has_piece, hn::Lt(begin, end));
    if (hn::AllFalse(d, piece.is_here))
        return false;
    piece.near_m = piece_near;
    const V per_m = hn::Div(one, rays.step), past = hn::Add(rays.last_line, one);
    const auto index_at = [&](V t) { return hn::MulAdd(hn::Sub(t, rays.near_m), per_m, rays.near_index); };
    const auto distance_at = [&](V index) {
        return hn::MulAdd(hn::Sub(index, rays.near_index), rays.step, rays.near_m);
    };
    piece.whole_begin = clamped(hn::Ceil(index_at(begin)), rays.first_line, past);
    piece.whole_past = clamped(hn::Floor(index_at(end)), rays.first_line, past);
    const V left = clamped(distance_at(piece.whole_begin), begin, end);
    const V right = hn::Max(clamped(distance_at(piece.whole_past), begin, end), left);
    piece.begin_length = hn::Sub(left, begin);
    piece.end_length = hn::Sub(end, right);
    piece.begin_middle = hn::MulAdd(half, piece.begin_length, begin);
    piece.end_middle = hn::NegMulAdd(half, piece.end_length, end);
    const auto is_lit_at = [&](V line) {
        const auto at = hn::ConvertTo(di, hn::Sub(clamped(line, rays.first_line, rays.last_line),
                                                  hn::Set(d, static_cast<float>(rays.row.first))));
        return hn::And(piece.is_here, hn::Ge(rays.slope, hn::GatherIndex(d, rays.row.slopes, at)));
    };
    piece.begin_lit = is_lit_at(hn::Sub(piece.whole_begin, one));
    piece.end_lit = is_lit_at(piece.whole_past);
    piece.has_whole = hn::And(piece.is_here, hn::Lt(piece.whole_begin, piece.whole_past));
    piece.outer_begin = piece.outer_end = piece.inner_begin = piece.inner_end = 0;
    if (!hn::AllFalse(d, piece.has_whole)) {
        const V big = hn::Set(d, 1e9f), none = hn::Zero(d);
        const auto block_of = [&](float line) {
            return (static_cast<std::int32_t>(line) - rays.row.first) / block_lines;
        };
        const auto block_after = [&](float line) {
            return (static_cast<std::int32_t>(line) - rays.row.first + block_lines - 1) / block_lines;
        };
        const V begin_or_big = hn::IfThenElse(piece.has_whole, piece.whole_begin, big),
                begin_or_none = hn::IfThenElse(piece.has_whole, piece.whole_begin, none),
                past_or_big = hn::IfThenElse(piece.has_whole, piece.whole_past, big),
                past_or_none = hn::IfThenElse(piece.has_whole, piece.whole_past, none);
        piece.outer_begin = block_of(least_of(begin_or_big));
        piece.outer_end = block_after(most_of(past_or_none));
        piece.inner_begin = block_after(most_of(begin_or_none));
        piece.inner_end = std::max(piece.inner_begin, block_of(least_of(past_or_big)));
        std::uint64_t any = 0;
        for (std::int32_t start = rays.blocks.first, word = 0; start < piece.outer_end;
             start += blocks_per_word, ++word)
            any |= rays.blocks.some_lit[static_cast<std::size_t>(word)] &
                   PacketBlocks::bits_between(piece.outer_begin, piece.outer_end, start);
        if (any != 0)
            return true;
        piece.outer_end = piece.outer_begin;
    }
    return !hn::AllFalse(d, hn::Or(piece.begin_lit, piece.end_lit));
}

/// Source and optical depth of one channel of the piece.
struct PacketMedium {
    V source, depth_at_near, depth_per_m;
};

/// Sums of the series over lit lines, a lane per ray.
template <int channels, bool is_counted>
struct PacketSum {
    const PacketRays& rays;
    const PacketPiece& piece;
    V in_block[channels][block_lines], of_block[channels][block_lines];
    V block_sum[channels], depth_per_line[channels], first_depth[channels]; ///< At the middle of line 0.
    V of_terms[channels], count;

    PacketSum(const PacketRays& packet, const PacketPiece& at, const PacketMedium* media) : rays(packet), piece(at) {
        const V line_0 = hn::MulAdd(hn::Sub(hn::Set(d, 0.5f), rays.near_index), rays.step, rays.near_m);
        for (int c = 0; c < channels; ++c) {
            const V gain = depth_per_line[c] = hn::Mul(media[c].depth_per_m, rays.step);
            first_depth[c] = hn::MulAdd(media[c].depth_per_m, hn::Sub(line_0, piece.near_m), media[c].depth_at_near);
            fill_powers(exp_of(d, hn::Neg(gain)), in_block[c]);
            fill_powers(exp_of(d, hn::Mul(gain, hn::Set(d, -float{block_lines}))), of_block[c]);
            const V one = in_block[c][0];
            block_sum[c] = hn::Mul(hn::Mul(hn::Add(one, in_block[c][1]), hn::Add(one, in_block[c][2])),
                                   hn::Mul(hn::Add(one, in_block[c][4]), hn::Add(one, in_block[c][8])));
            of_terms[c] = hn::Zero(d);
        }
        count = hn::Zero(d);
    }

    /// The lit lines of a block: their terms, relative to the first, and their number.
    template <class Lit>
    HWY_INLINE void sum_block(const Lit& lit, V (&sum)[channels], V& lines) const {
        [[maybe_unused]] const V one = hn::Set(d, 1.0f);
        for (int c = 0; c < channels; ++c)
            sum[c] = hn::Zero(d);
        lines = hn::Zero(d);
        for (std::size_t line = 0; line < block_lines; ++line) {
            const auto is_lit = lit(line);
            if constexpr (is_counted)
                lines = hn::IfThenElse(is_lit, hn::Add(lines, one), lines);
            for (int c = 0; c < channels; ++c)
                sum[c] = hn::IfThenElse(is_lit, hn::Add(sum[c], in_block[c][line]), sum[c]);
        }
    }
    HWY_INLINE LaneMask is_lit(const float* slopes, std::size_t line) const {
        return hn::Ge(rays.slope, hn::Set(d, slopes[line]));
    }

    /// A block that some rays have only some lines of, or none.
    HWY_INLINE void add_outer(std::int32_t block, bool is_all_lit, const V (&weight)[channels], V (&of_lit)[channels]) {
        const float* slopes = rays.row.slopes + block * block_lines;
        const V start = hn::Set(d, static_cast<float>(rays.row.first + block * block_lines)),
                width = hn::Set(d, float{block_lines});
        const V begin = hn::Sub(piece.whole_begin, start), past = hn::Sub(piece.whole_past, start);
        const auto touches = hn::And(piece.has_whole, hn::And(hn::Lt(begin, width), hn::Gt(past, hn::Zero(d))));
        const bool is_begun = hn::AllFalse(d, hn::And(touches, hn::Gt(begin, hn::Zero(d))));
        const bool is_whole = is_begun && hn::AllFalse(d, hn::And(touches, hn::Lt(past, width)));
        V sum[channels], lines;
        if (is_whole && is_all_lit) {
            for (int c = 0; c < channels; ++c)
                of_lit[c] = hn::IfThenElse(touches, hn::Add(of_lit[c], weight[c]), of_lit[c]);
            count = hn::IfThenElse(touches, hn::Add(count, width), count);
            return;
        }
        const auto at = [](std::size_t line) { return hn::Set(d, static_cast<float>(line)); };
        if (is_whole)
            sum_block([&](std::size_t line) { return is_lit(slopes, line); }, sum, lines);
        else if (is_begun)
            sum_block([&](std::size_t line) { return hn::And(is_lit(slopes, line), hn::Lt(at(line), past)); }, sum,
                      lines);
        else
            sum_block(
                [&](std::size_t line) {
                    return hn::And(is_lit(slopes, line), hn::And(hn::Ge(at(line), begin), hn::Lt(at(line), past)));
                },
                sum, lines);
        count = hn::IfThenElse(touches, hn::Add(count, lines), count);
        for (int c = 0; c < channels; ++c) // the weight of a ray that is elsewhere may be infinite
            of_terms[c] = hn::IfThenElse(touches, hn::MulAdd(sum[c], weight[c], of_terms[c]), of_terms[c]);
    }

    HWY_INLINE void add_blocks() {
        V of_lit[channels]; // of the first lines of blocks that are lit for all
        for (int c = 0; c < channels; ++c)
            of_lit[c] = hn::Zero(d);
        std::int32_t lit_count = 0;
        for (std::int32_t start = rays.blocks.first, word = 0; start < piece.outer_end;
             start += blocks_per_word, ++word) {
            const std::uint64_t inner = PacketBlocks::bits_between(piece.inner_begin, piece.inner_end, start);
            const std::uint64_t some = rays.blocks.some_lit[static_cast<std::size_t>(word)] &
                                       PacketBlocks::bits_between(piece.outer_begin, piece.outer_end, start);
            if (some == 0)
                continue;
            const std::uint64_t all = rays.blocks.all_lit[static_cast<std::size_t>(word)] & some & inner;
            V weight[blocks_per_word][channels]; // of the first lines of blocks
            for (std::int32_t group = 0; group < blocks_per_word; group += block_lines) {
                if ((some >> group & 0xffff) == 0)
                    continue;
                const V line = hn::Set(d, static_cast<float>(rays.row.first + (start + group) * block_lines));
                for (int c = 0; c < channels; ++c) {
                    const V at_first = exp_of(d, hn::Neg(hn::MulAdd(line, depth_per_line[c], first_depth[c])));
                    for (std::int32_t block = 0; block < block_lines; ++block)
                        weight[group + block][c] = hn::Mul(at_first, of_block[c][block]);
                }
            }
            for (std::uint64_t left = all; left != 0; left &= left - 1)
                for (int c = 0; c < channels; ++c)
                    of_lit[c] = hn::Add(of_lit[c], weight[std::countr_zero(left)][c]);
            lit_count += std::popcount(all);
            for (std::uint64_t left = some & inner & ~all; left != 0; left &= left - 1) {
                const std::int32_t block = std::countr_zero(left);
                const float* slopes = rays.row.slopes + (start + block) * block_lines;
                V sum[channels], lines;
                sum_block([&](std::size_t line) { return is_lit(slopes, line); }, sum, lines);
                count = hn::Add(count, lines);
                for (int c = 0; c < channels; ++c)
                    of_terms[c] = hn::MulAdd(sum[c], weight[block][c], of_terms[c]);
            }
            for (std::uint64_t left = some & ~inner; left != 0; left &= left - 1) {
                const std::int32_t block = std::countr_zero(left);
                add_outer(start + block, (rays.blocks.all_lit[static_cast<std::size_t>(word)] >> block & 1) != 0,
                          weight[block], of_lit);
            }
        }
        for (int c = 0; c < channels; ++c)
            of_terms[c] = hn::MulAdd(of_lit[c], block_sum[c], of_terms[c]);
        count = hn::Add(count, hn::Set(d, static_cast<float>(lit_count * block_lines)));
    }
};

/// Adds what all channels of a piece send, of which only `channels` differ in more than their source.
template <int channels, bool is_counted>
static void add_piece(const PacketRays& rays, const PacketPiece& piece, const PacketMedium* media, V (&radiance)[3],
                      V& length_m) {
    PacketSum<channels, is_counted> sum(rays, piece, media);
    if (piece.outer_begin < piece.outer_end)
        sum.add_blocks();
    const V half = hn::Set(d, 0.5f);
    V scattered[channels]; // of a source of one
    for (int c = 0; c < channels; ++c) {
        const auto of_end = [&](LaneMask is_lit, V middle, V length) {
            const V depth = hn::MulAdd(media[c].depth_per_m, hn::Sub(middle, piece.near_m), media[c].depth_at_near);
            const V mean = mean_around_middle(hn::Mul(half, hn::Mul(media[c].depth_per_m, length)));
            return hn::IfThenElseZero(is_lit, hn::Mul(length, hn::Mul(exp_of(d, hn::Neg(depth)), mean)));
        };
        const V of_line = hn::Mul(rays.step, mean_around_middle(hn::Mul(half, sum.depth_per_line[c])));
        scattered[c] = hn::Add(hn::Add(of_end(piece.begin_lit, piece.begin_middle, piece.begin_length),
                                       of_end(piece.end_lit, piece.end_middle, piece.end_length)),
                               hn::IfThenElseZero(piece.has_whole, hn::Mul(sum.of_terms[c], of_line)));
    }
    for (int c = 0; c < 3; ++c)
        radiance[c] = hn::MulAdd(media[c].source, scattered[channels == 3 ? c : 0], radiance[c]);
    length_m = hn::Add(length_m, hn::IfThenElseZero(piece.begin_lit, piece.begin_length));
    length_m = hn::Add(length_m, hn::IfThenElseZero(piece.end_lit, piece.end_length));
    length_m = hn::Add(length_m, hn::IfThenElseZero(piece.has_whole, hn::Mul(sum.count, rays.step)));
}

/// False where the packet is too dense: nothing of radiance and length_m may be used then.
template <bool is_counted>
static bool add_pieces(const PacketRays& rays, const ScatterPiece* pieces, V (&radiance)[3], V& length_m) {
    static_assert(sizeof(ScatterPiece) == 11 * sizeof(float));
    const auto most = hn::GetLane(hn::MaxOfLanes(di, rays.piece_count));
    for (std::int32_t index = 0; index < most; ++index) {
        const auto number = hn::Set(di, index);
        const auto has_piece = hn::Lt(number, rays.piece_count);
        const I at = hn::Mul(hn::Add(rays.first_piece, hn::IfThenElseZero(has_piece, number)), hn::Set(di, 11));
        const auto* floats = reinterpret_cast<const float*>(pieces);
        const auto field = [&](std::size_t offset) { return hn::GatherIndex(d, floats + offset, at); };
        PacketPiece piece;
        if (!place_piece(rays, field(0), field(1), hn::RebindMask(d, has_piece), piece))
            continue;
        PacketMedium media[3];
        auto is_dense = hn::FirstN(d, 0);
        for (std::size_t c = 0; c < 3; ++c) { // a ray without this piece sends nothing, and must not overflow
            media[c].source = hn::IfThenElseZero(piece.is_here, field(2 + c));
            media[c].depth_at_near = hn::IfThenElseZero(piece.is_here, field(5 + c));
            media[c].depth_per_m = hn::IfThenElseZero(piece.is_here, field(8 + c));
            const V gain = hn::Mul(media[c].depth_per_m, rays.step);
            const V lines = hn::Sub(rays.last_line, rays.first_line);
            is_dense = hn::Or(is_dense, hn::Or(hn::Gt(hn::Abs(gain), hn::Set(d, most_packet_gain)),
                                               hn::Lt(hn::Mul(gain, lines), hn::Set(d, -30.0f))));
        }
        if (!hn::AllFalse(d, is_dense))
            return false;
        const auto same_as_red = [&](int c) {
            return hn::And(hn::Eq(media[c].depth_per_m, media[0].depth_per_m),
                           hn::Eq(media[c].depth_at_near, media[0].depth_at_near));
        };
        if (hn::AllTrue(d, hn::And(same_as_red(1), same_as_red(2))))
            add_piece<1, is_counted>(rays, piece, media, radiance, length_m);
        else
            add_piece<3, is_counted>(rays, piece, media, radiance, length_m);
    }
    return true;
}

/// Rays [begin, end) of one slice, at most `lanes`; false where they have to be asked one by one.
static bool add_packet(const Rows& rows, const Asked& asked, std::size_t begin, std::size_t end,
                       const ScatterPiece* pieces, std::span<Rgb> radiance, std::span<float> lit_length_m) {
    const auto is_member = hn::FirstN(d, end - begin);
    const auto column = [&](const Asked::Column<float>& values) { // those which are missing are like the first
        return hn::IfThenElse(is_member, hn::LoadU(d, &values[begin]), hn::Set(d, values[begin]));
    };
    PacketRays packet;
    packet.row = rows.row(asked.slice[begin]);
    packet.slope = column(asked.slope);
    packet.first_line = column(asked.first_line);
    packet.last_line = column(asked.last_line);
    if (!packet.blocks.find(packet.row, least_of(packet.slope), most_of(packet.slope),
                            static_cast<std::int32_t>(least_of(packet.first_line)),
                            static_cast<std::int32_t>(most_of(packet.last_line))))
        return true;
    packet.near_m = column(asked.near_m);
    packet.far_m = column(asked.far_m);
    packet.near_index = column(asked.near_index);
    packet.step = column(asked.m_per_line);
    const auto is_ray = hn::RebindMask(di, is_member);
    packet.first_piece = hn::IfThenElseZero(is_ray, hn::LoadU(di, &asked.first_piece[begin]));
    packet.piece_count = hn::IfThenElseZero(is_ray, hn::LoadU(di, &asked.piece_count[begin]));
    V sums[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)}, length_m = hn::Zero(d);
    if (!(lit_length_m.empty() ? add_pieces<false>(packet, pieces, sums, length_m)
                               : add_pieces<true>(packet, pieces, sums, length_m)))
        return false;
    alignas(64) float results[4][lanes];
    for (std::size_t c = 0; c < 3; ++c)
        hn::Store(sums[c], d, results[c]);
    hn::Store(length_m, d, results[3]);
    for (std::size_t lane = 0; lane < end - begin; ++lane) {
        const auto ray = static_cast<std::size_t>(asked.number[begin + lane]);
        radiance[ray] += Rgb(results[0][lane], results[1][lane], results[2][lane]);
        if (!lit_length_m.empty())
            lit_length_m[ray] += results[3][lane];
    }
    return true;
}
} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
