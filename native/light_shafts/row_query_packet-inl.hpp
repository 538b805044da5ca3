// SPDX-License-Identifier: GPL-3.0-or-later
// Rays of one slice side by side, a lane each, compiled once per SIMD target. Neighbours of a picture that share a row
// have almost the same slope: most blocks of 16 lines are wholly lit or dark for all of them together.
// Based on: Wald et al., Interactive Rendering with Coherent Ray Tracing, Eurographics 2001 (packets).
// Differs:  no traversal; per piece a table of the series' terms at the starts of 16 blocks.
// Bound:    full HD, forest at 2,048 lines, per packet of 16 rays (counted): 15 mixed blocks of 20 operations, 23 lit ones
//           of 2, 15 that not all rays reach (41 in the RGB query of three pieces) of 5 to 35, and about 350 for the rays'
//           own numbers; 4 bytes per line and packet, from the first-level cache.
#if defined(TYNDALL_ROW_QUERY_PACKET_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TYNDALL_ROW_QUERY_PACKET_INL
#undef TYNDALL_ROW_QUERY_PACKET_INL
#else
#define TYNDALL_ROW_QUERY_PACKET_INL
#endif
#include "light_shafts/row_query_terms-inl.hpp"
#include <bit>

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
/// Fewer rays that share a row are cheaper one by one.
static constexpr std::size_t least_packet = std::max<std::size_t>(2, lanes / 4);

/// Source and optical depth of one channel of the piece.
struct PacketMedium {
    V source, depth_at_near, depth_per_m;
};

/// Sums of the series over lit lines, a lane per ray.
template <int channels, class Terms>
struct PacketSum {
    const PacketRays& rays;
    const PacketPiece& piece;
    Gains<channels> gain;
    V of_terms[channels], count;

    PacketSum(const PacketRays& packet, const PacketPiece& at, const PacketMedium* media)
        : rays(packet), piece(at), media_(media) {
        for (int c = 0; c < channels; ++c) {
            gain[c] = hn::Mul(media[c].depth_per_m, rays.step);
            of_terms[c] = hn::Zero(d);
        }
        count = hn::Zero(d);
    }

    HWY_INLINE void add_blocks() {
        const Terms terms(gain);
        const V origin = hn::MulAdd(hn::Sub(hn::Set(d, Terms::anchor), rays.near_index), rays.step,
                                    hn::Sub(rays.near_m, piece.near_m));
        // Not the members: a vector that goes through memory under a mask makes the next one wait.
        V terms_sum[channels], lines_sum = hn::Zero(d);
        V of_block[channels][block_lines], first_depth[channels], of_lit[channels];
        for (int c = 0; c < channels; ++c) {
            fill_powers(terms.block_ratio(gain[c]), of_block[c]);
            first_depth[c] = hn::MulAdd(media_[c].depth_per_m, origin, media_[c].depth_at_near); // where line 0 begins
            of_lit[c] = terms_sum[c] = hn::Zero(d);
        }
        std::int32_t lit_count = 0;
        for (std::int32_t start = rays.blocks.first, word = 0; start < piece.outer_end;
             start += blocks_per_word, ++word) {
            const std::uint64_t inner = PacketBlocks::bits_between(piece.inner_begin, piece.inner_end, start);
            const std::uint64_t some = rays.blocks.some_lit[static_cast<std::size_t>(word)] &
                                       PacketBlocks::bits_between(piece.outer_begin, piece.outer_end, start);
            const std::uint64_t all = rays.blocks.all_lit[static_cast<std::size_t>(word)] & some;
            V of_group[blocks_per_word / block_lines][channels];
            for (std::int32_t group = 0; group < blocks_per_word / block_lines; ++group) {
                if ((some >> group * block_lines & 0xffff) == 0)
                    continue;
                const std::int32_t block = start + group * block_lines;
                const V line = hn::Set(d, static_cast<float>(rays.row.first + block * block_lines));
                for (int c = 0; c < channels; ++c)
                    of_group[group][c] = exp_of(d, hn::Neg(hn::MulAdd(line, gain[c], first_depth[c])));
            }
            for (std::uint64_t left = all & inner; left != 0; left &= left - 1) {
                const int block = std::countr_zero(left);
                for (int c = 0; c < channels; ++c)
                    of_lit[c] =
                        hn::MulAdd(of_group[block / block_lines][c], of_block[c][block % block_lines], of_lit[c]);
            }
            lit_count += std::popcount(all & inner);
            for (std::uint64_t left = some & inner & ~all; left != 0; left &= left - 1) {
                const int block = std::countr_zero(left);
                V sum[channels], lines;
                terms.add_up(rays, rays.row.slopes + (start + block) * block_lines, sum, lines);
                lines_sum = hn::Add(lines_sum, lines);
                for (int c = 0; c < channels; ++c)
                    terms_sum[c] = hn::MulAdd(hn::Mul(sum[c], of_block[c][block % block_lines]),
                                              of_group[block / block_lines][c], terms_sum[c]);
            }
            std::uint64_t outer = some & ~inner; // some rays have none or some lines
            if constexpr (Terms::is_finite_anywhere) {
                const std::uint64_t lit_outside = all & outer & ~piece.border_blocks(start);
                outer &= ~lit_outside;
                for (std::uint64_t left = lit_outside; left != 0; left &= left - 1) { // all lines, or none
                    const int block = std::countr_zero(left);
                    const I first = hn::Set(di, (start + block) * block_lines);
                    const auto is_inside = hn::AndNot(hn::Gt(piece.begin_line, first), hn::Gt(piece.past_line, first));
                    const auto counts = hn::RebindMask(d, is_inside);
                    lines_sum = hn::IfThenElse(counts, hn::Add(lines_sum, hn::Set(d, float{block_lines})), lines_sum);
                    for (int c = 0; c < channels; ++c)
                        of_lit[c] = hn::IfThenElse(
                            counts,
                            hn::MulAdd(of_group[block / block_lines][c], of_block[c][block % block_lines], of_lit[c]),
                            of_lit[c]);
                }
            }
            for (std::uint64_t left = outer; left != 0; left &= left - 1) {
                const int block = std::countr_zero(left);
                const I first = hn::Set(di, (start + block) * block_lines);
                const I begin = hn::Sub(piece.begin_line, first), past = hn::Sub(piece.past_line, first);
                const float* slopes = rays.row.slopes + (start + block) * block_lines;
                V sum[channels], lines;
                if constexpr (Terms::is_finite_anywhere) { // what is multiplied by no lines, too
                    terms.add_up_range(rays, slopes, begin, past, sum, lines);
                    lines_sum = hn::Add(lines_sum, lines);
                    for (int c = 0; c < channels; ++c)
                        terms_sum[c] = hn::MulAdd(hn::Mul(sum[c], of_block[c][block % block_lines]),
                                                  of_group[block / block_lines][c], terms_sum[c]);
                    continue;
                }
                const I width = hn::Set(di, block_lines);
                const auto touches =
                    hn::And(hn::Lt(begin, past), hn::And(hn::Lt(begin, width), hn::Gt(past, hn::Zero(di))));
                const auto is_cut = hn::And(touches, hn::Or(hn::Gt(begin, hn::Zero(di)), hn::Lt(past, width)));
                lines = hn::Set(d, float{block_lines});
                if (!hn::AllFalse(di, is_cut))
                    terms.add_up_range(rays, slopes, begin, past, sum, lines);
                else if ((all >> block & 1) == 0)
                    terms.add_up(rays, slopes, sum, lines);
                else
                    for (int c = 0; c < channels; ++c)
                        sum[c] = terms.block_sum[c];
                const auto counts = hn::RebindMask(d, touches);
                lines_sum = hn::IfThenElse(counts, hn::Add(lines_sum, lines), lines_sum);
                for (int c = 0; c < channels; ++c) { // the weight of a ray that is elsewhere may be infinite
                    const V weight = hn::Mul(of_block[c][block % block_lines], of_group[block / block_lines][c]);
                    terms_sum[c] = hn::IfThenElse(counts, hn::MulAdd(sum[c], weight, terms_sum[c]), terms_sum[c]);
                }
            }
        }
        for (int c = 0; c < channels; ++c)
            of_terms[c] = hn::MulAdd(of_lit[c], terms.block_sum[c], terms_sum[c]);
        count = hn::Add(lines_sum, hn::Set(d, static_cast<float>(lit_count * block_lines)));
    }

private:
    const PacketMedium* media_;
};

/// Adds what all channels of a piece send, of which only `channels` differ in more than their source.
template <int channels, class Terms>
static void add_piece(const PacketRays& rays, const PacketPiece& piece, const PacketMedium* media, V (&radiance)[3],
                      V& length_m) {
    PacketSum<channels, Terms> sum(rays, piece, media);
    if (piece.outer_begin < piece.outer_end)
        sum.add_blocks();
    const V half = hn::Set(d, 0.5f);
    V scattered[channels]; // of a source of one
    for (int c = 0; c < channels; ++c) {
        const auto of_end = [&](LaneMask is_lit, V middle, V length) {
            if (hn::AllFalse(d, is_lit))
                return hn::Zero(d);
            const V depth = hn::MulAdd(media[c].depth_per_m, hn::Sub(middle, piece.near_m), media[c].depth_at_near);
            const V mean = mean_around_middle(hn::Mul(half, hn::Mul(media[c].depth_per_m, length)));
            return hn::IfThenElseZero(is_lit, hn::Mul(length, hn::Mul(exp_of(d, hn::Neg(depth)), mean)));
        };
        const V of_line = hn::Mul(rays.step, mean_around_middle(hn::Mul(half, sum.gain[c])));
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
        V most_gain = hn::Zero(d), least_gain = most_gain;
        for (std::size_t c = 0; c < 3; ++c) { // a ray without this piece sends nothing, and must not overflow
            media[c].source = hn::IfThenElseZero(piece.is_here, field(2 + c));
            media[c].depth_at_near = hn::IfThenElseZero(piece.is_here, field(5 + c));
            media[c].depth_per_m = hn::IfThenElseZero(piece.is_here, field(8 + c));
            const V gain = hn::Mul(media[c].depth_per_m, rays.step);
            most_gain = hn::Max(most_gain, gain);
            least_gain = hn::Min(least_gain, gain);
        }
        const auto is_below = [&](float limit) {
            return hn::AllTrue(d, hn::Lt(hn::Max(most_gain, hn::Neg(least_gain)), hn::Set(d, limit)));
        };
        const V lines = hn::Sub(rays.last_line, rays.first_line);
        if (!is_below(most_packet_gain) || !hn::AllTrue(d, hn::Gt(hn::Mul(least_gain, lines), hn::Set(d, -30.0f))))
            return false;
        const bool is_thin = is_below(most_thin_gain);
        const auto same_as_red = [&](int c) {
            return hn::And(hn::Eq(media[c].depth_per_m, media[0].depth_per_m),
                           hn::Eq(media[c].depth_at_near, media[0].depth_at_near));
        };
        if (hn::AllTrue(d, hn::And(same_as_red(1), same_as_red(2))))
            is_thin ? add_piece<1, ThinTerms<1>>(rays, piece, media, radiance, length_m)
                    : add_piece<1, DenseTerms<1>>(rays, piece, media, radiance, length_m);
        else
            is_thin ? add_piece<3, ThinTerms<3>>(rays, piece, media, radiance, length_m)
                    : add_piece<3, DenseTerms<3>>(rays, piece, media, radiance, length_m);
    }
    return true;
}

/// Pieces of a vector of rays from `begin` on: those of many rays do not come from the cache, and gathers wait for them.
static HWY_INLINE void prefetch_pieces(const Asked& asked, std::size_t begin, const ScatterPiece* pieces) {
    if (begin >= asked.count)
        return;
    const std::size_t last = std::min(begin + lanes, asked.count) - 1;
    const auto* const end = reinterpret_cast<const char*>(pieces + asked.first_piece[last] + asked.piece_count[last]);
    for (const auto* at = reinterpret_cast<const char*>(pieces + asked.first_piece[begin]); at < end; at += 64)
        __builtin_prefetch(at);
}

/// Rays [begin, end) of one slice, at most `lanes`; false where they have to be asked one by one.
static bool add_packet(const Rows& rows, const Asked& asked, std::size_t begin, std::size_t end,
                       const ScatterPiece* pieces, std::span<Rgb> radiance, std::span<float> lit_length_m) {
    // Lanes without a ray are like the first, but have no pieces.
    const auto is_member = hn::RebindMask(di, hn::FirstN(d, end - begin));
    const I first = hn::Set(di, static_cast<std::int32_t>(asked.ray(begin)));
    const I at = asked.is_in_order ? first : hn::IfThenElse(is_member, hn::LoadU(di, &asked.order[begin]), first);
    const auto column = [&]<class Value>(const Asked::Column<Value>& values) {
        const hn::Simd<Value, lanes, 0> tag;
        if (!asked.is_in_order)
            return hn::GatherIndex(tag, values.data(), at);
        return hn::IfThenElse(hn::RebindMask(tag, is_member), hn::LoadU(tag, &values[begin]),
                              hn::Set(tag, values[begin]));
    };
    PacketRays packet;
    packet.row = rows.row(asked.slice[asked.ray(begin)]);
    packet.slope = column(asked.slope);
    packet.first_line = column(asked.first_line);
    packet.last_line = column(asked.last_line);
    packet.least_slope = least_of(packet.slope);
    packet.most_slope = most_of(packet.slope);
    if (!packet.blocks.find(packet.row, packet.least_slope, packet.most_slope,
                            static_cast<std::int32_t>(least_of(packet.first_line)),
                            static_cast<std::int32_t>(most_of(packet.last_line))))
        return true;
    prefetch_pieces(asked, end, pieces); // where these rays are lit, the next ones mostly are
    packet.near_m = column(asked.near_m);
    packet.far_m = column(asked.far_m);
    packet.near_index = column(asked.near_index);
    packet.step = column(asked.m_per_line);
    packet.lines_per_m = column(asked.lines_per_m);
    packet.first_piece = column(asked.first_piece);
    packet.piece_count = hn::IfThenElseZero(is_member, column(asked.piece_count));
    V sums[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)}, length_m = hn::Zero(d);
    if (!add_pieces(packet, pieces, sums, length_m))
        return false;
    const auto number_at = [&](std::size_t ray) { return static_cast<std::size_t>(asked.number[asked.ray(ray)]); };
    const std::size_t first_number = number_at(begin);
    if (asked.is_in_order && end - begin == lanes && number_at(end - 1) - first_number == lanes - 1) {
        static_assert(sizeof(Rgb) == 3 * sizeof(float));
        float* const of_rays = &radiance[first_number].x;
        V red, green, blue;
        hn::LoadInterleaved3(d, of_rays, red, green, blue);
        hn::StoreInterleaved3(hn::Add(red, sums[0]), hn::Add(green, sums[1]), hn::Add(blue, sums[2]), d, of_rays);
        if (!lit_length_m.empty()) {
            float* const lengths_m = &lit_length_m[first_number];
            hn::StoreU(hn::Add(hn::LoadU(d, lengths_m), length_m), d, lengths_m);
        }
        return true;
    }
    alignas(64) float results[4][lanes];
    for (std::size_t c = 0; c < 3; ++c)
        hn::Store(sums[c], d, results[c]);
    hn::Store(length_m, d, results[3]);
    for (std::size_t lane = 0; lane < end - begin; ++lane) {
        const std::size_t ray = number_at(begin + lane);
        radiance[ray] += Rgb(results[0][lane], results[1][lane], results[2][lane]);
        if (!lit_length_m.empty())
            lit_length_m[ray] += results[3][lane];
    }
    return true;
}
} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
