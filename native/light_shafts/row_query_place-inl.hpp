// SPDX-License-Identifier: GPL-3.0-or-later
// Rays of one slice side by side, a lane each, and where their pieces lie in the row, compiled once per SIMD target.
#if defined(TYNDALL_ROW_QUERY_PLACE_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TYNDALL_ROW_QUERY_PLACE_INL
#undef TYNDALL_ROW_QUERY_PLACE_INL
#else
#define TYNDALL_ROW_QUERY_PLACE_INL
#endif
#include "light_shafts/row_query_asked-inl.hpp"
#include "light_shafts/row_query_pieces-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
using LaneMask = hn::Mask<LineTag>;
using I = hn::Vec<decltype(di)>;

static HWY_INLINE float least_of(V v) { return hn::GetLane(hn::MinOfLanes(d, v)); }
static HWY_INLINE float most_of(V v) { return hn::GetLane(hn::MaxOfLanes(d, v)); }

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
struct PacketRays : RaysInRow {
    RowView row;
    float least_slope, most_slope;
    V slope, far_m;
    I first_piece, piece_count;
    PacketBlocks blocks;
};

/// One piece of each ray: where it lies in the row.
struct PacketPiece : PieceInRow {
    LaneMask is_here, has_whole;
    V near_m;                ///< Its own, which depths are counted from.
    I begin_line, past_line; ///< Whole lines, from the row's first; equal where none are.
    LaneMask begin_lit, end_lit;
    std::int32_t outer_begin, outer_end; ///< Blocks that any ray has lines of.
    std::int32_t inner_begin, inner_end; ///< Blocks that all rays have all lines of.

    /// Of the 64 blocks from `start` on, those that hold the first line of a ray, or the one past its last.
    [[nodiscard]] std::uint64_t border_blocks(std::int32_t start) const {
        static_assert(block_lines == 1 << 4);
        const auto of_half = [&](std::int32_t first) {
            const auto bit_of = [&](I line) {
                const I block = hn::Sub(hn::ShiftRight<4>(line), hn::Set(di, first));
                const auto is_in_half = hn::AndNot(hn::Lt(block, hn::Zero(di)), hn::Lt(block, hn::Set(di, 32)));
                return hn::IfThenElseZero(is_in_half, hn::Shl(hn::Set(di, 1), hn::And(block, hn::Set(di, 31))));
            };
            alignas(64) std::uint64_t bits[lanes / 2];
            const hn::Repartition<std::uint64_t, decltype(di)> pairs;
            hn::Store(hn::BitCast(pairs, hn::Or(bit_of(begin_line), bit_of(past_line))), pairs, bits);
            std::uint64_t all = 0;
            for (const std::uint64_t pair : bits)
                all |= pair;
            return static_cast<std::uint32_t>(all | all >> 32);
        };
        return of_half(start) | std::uint64_t{of_half(start + 32)} << 32;
    }
};

/// Nothing is known of the medium yet: most pieces end here, in the dark.
static HWY_INLINE bool place_piece(const PacketRays& rays, V piece_near, V piece_far, LaneMask has_piece,
                                   PacketPiece& piece) {
    const V begin = hn::Max(piece_near, rays.near_m), end = hn::Min(piece_far, rays.far_m);
    piece.is_here = hn::And(has_piece, hn::Lt(begin, end));
    if (hn::AllFalse(d, piece.is_here))
        return false;
    piece.near_m = piece_near;
    piece.place(rays, begin, end);
    const V first = hn::Set(d, static_cast<float>(rays.row.first));
    const auto in_row = [&](V line) { return hn::ConvertTo(di, hn::Sub(line, first)); };
    const auto is_lit_at = [&](V line) {
        return hn::And(piece.is_here, hn::Ge(rays.slope, hn::GatherIndex(d, rays.row.slopes, in_row(line))));
    };
    piece.begin_lit = is_lit_at(piece.line_before(rays));
    piece.end_lit = is_lit_at(piece.line_after(rays));
    piece.has_whole = hn::And(piece.is_here, hn::Lt(piece.whole_begin, piece.whole_past));
    const auto has_whole = hn::RebindMask(di, piece.has_whole);
    piece.begin_line = in_row(piece.whole_begin);
    piece.past_line = hn::IfThenElse(has_whole, in_row(piece.whole_past), piece.begin_line);
    piece.outer_begin = piece.outer_end = piece.inner_begin = piece.inner_end = 0;
    if (!hn::AllFalse(d, piece.has_whole)) {
        const I big = hn::Set(di, 1 << 30);
        const auto least_of_lines = [](I v) { return hn::GetLane(hn::MinOfLanes(di, v)); };
        const auto most_of_lines = [](I v) { return hn::GetLane(hn::MaxOfLanes(di, v)); };
        const auto block_after = [](std::int32_t line) { return (line + block_lines - 1) / block_lines; };
        piece.outer_begin = least_of_lines(hn::IfThenElse(has_whole, piece.begin_line, big)) / block_lines;
        piece.outer_end = block_after(most_of_lines(hn::IfThenElseZero(has_whole, piece.past_line)));
        piece.inner_begin = block_after(most_of_lines(hn::IfThenElseZero(has_whole, piece.begin_line)));
        piece.inner_end =
            std::max(piece.inner_begin, least_of_lines(hn::IfThenElse(has_whole, piece.past_line, big)) / block_lines);
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

} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
