// SPDX-License-Identifier: GPL-3.0-or-later
// Rays that share a row with too few others, one by one, compiled once per SIMD target: lines side by side, a lane each.
// Bound:    per piece and channel 7 exponentials; per block of 16 lines that a shadow's border crosses one compare and
//           one masked multiply-add per channel.
#if defined(TYNDALL_ROW_QUERY_ALONE_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TYNDALL_ROW_QUERY_ALONE_INL
#undef TYNDALL_ROW_QUERY_ALONE_INL
#else
#define TYNDALL_ROW_QUERY_ALONE_INL
#endif
#include "light_shafts/row_query_asked-inl.hpp"
#include "light_shafts/row_query_pieces-inl.hpp"
#include "light_shafts/row_query_scatter.hpp"

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
/// Lines [first, last] of a row, all of them whole, for one slope.
struct Stretch {
    RowView row;
    float slope;
    std::int32_t first, last;
};
/// Of one channel: the series' terms are exp(-gain * line), counted from the first line of the first block.
struct Series {
    Powers of_line;   ///< exp(-gain) ..
    Powers of_block;  ///< exp(-gain * 16) ..
    float of_group;   ///< exp(-gain * 256).
    float block_sum;  ///< Of a block's 16 terms.
    float last_block; ///< exp(-gain * 16 * blocks before the last one).
};

/// q^n for n = 0 .. 15, by the bits of n: cheaper than an exponential.
static HWY_INLINE V powers_of(const Powers& q, std::size_t part) {
    const auto n = hn::Add(hn::Iota(di, 0), hn::Set(di, static_cast<int>(part * lanes)));
    const auto factor = [&](int bit, float power) {
        return hn::IfThenElse(hn::RebindMask(d, hn::TestBit(n, hn::Set(di, bit))), hn::Set(d, power), hn::Set(d, 1.0f));
    };
    return hn::Mul(hn::Mul(factor(1, q.one), factor(2, q.two)), hn::Mul(factor(4, q.four), factor(8, q.eight)));
}

/// The lit lines of one block, without those outside [first, last].
static HWY_INLINE hn::Mask<LineTag> lit_in_end(const Stretch& stretch, V slope, std::int32_t block, std::int32_t first,
                                               std::size_t part) {
    const std::int32_t offset = block * block_lines + static_cast<std::int32_t>(part * lanes);
    // Not Iota(first): Highway 1.0 builds that lane by lane, and the load of it waits for all the stores.
    const auto line = hn::Add(hn::Iota(di, 0), hn::Set(di, stretch.row.first + offset));
    const auto belongs = hn::And(hn::Gt(line, hn::Set(di, first - 1)), hn::Lt(line, hn::Set(di, stretch.last + 1)));
    return hn::And(hn::Ge(slope, hn::LoadU(d, stretch.row.slopes + offset)), hn::RebindMask(d, belongs));
}

/// What has been summed up so far.
template <int channels>
struct Sums {
    V of_terms[channels], count;
    HWY_INLINE void add(int c, hn::Mask<LineTag> lit, V term, V weight) {
        of_terms[c] = hn::MulAdd(hn::IfThenElseZero(lit, term), weight, of_terms[c]);
    }
    HWY_INLINE void add_count(hn::Mask<LineTag> lit, float lines) {
        count = hn::IfThenElse(lit, hn::Add(count, hn::Set(d, lines)), count);
    }
};

/// sums[c]: of the terms of the lit lines; returns their number. No branch depends on where the stretch begins and ends,
/// and one on how many blocks are mixed: a branch that is guessed wrong costs as much as eight blocks.
template <int channels>
HWY_INLINE float sum_lit(const Stretch& stretch, const Series* series, float* result) {
    const RowView& row = stretch.row;
    const V slope = hn::Set(d, stretch.slope), one = hn::Set(d, 1.0f);
    const std::int32_t first_block = (stretch.first - row.first) / block_lines,
                       last_block = (stretch.last - row.first) / block_lines;
    const std::int32_t after_first = row.first + (first_block + 1) * block_lines;
    V in_block[channels][parts];
    Sums<channels> sums;
    sums.count = hn::Zero(d);
    for (int c = 0; c < channels; ++c)
        sums.of_terms[c] = hn::Zero(d);
    for (std::size_t part = 0; part < parts; ++part) {
        const auto at_first = lit_in_end(stretch, slope, first_block, stretch.first, part),
                   at_last = lit_in_end(stretch, slope, last_block, std::max(stretch.first, after_first), part);
        sums.add_count(at_first, 1.0f);
        sums.add_count(at_last, 1.0f);
        for (int c = 0; c < channels; ++c) {
            in_block[c][part] = powers_of(series[c].of_line, part);
            sums.add(c, at_first, in_block[c][part], one);
            sums.add(c, at_last, in_block[c][part], hn::Set(d, series[c].last_block));
        }
    }
    const std::int32_t inner_count = last_block - first_block - 1;
    if (inner_count > 0) {
        alignas(64) float weights[channels][blocks_per_word]; // of the first lines of blocks
        V of_block[channels][parts];
        for (int c = 0; c < channels; ++c)
            for (std::size_t part = 0; part < parts; ++part)
                of_block[c][part] = hn::Mul(powers_of(series[c].of_block, part), hn::Set(d, series[c].of_block.one));
        for (std::int32_t word = 0; word < inner_count; word += blocks_per_word) {
            const float* highest = row.highest + first_block + 1 + word;
            const float* lowest = row.lowest + first_block + 1 + word;
            const float* slopes = row.slopes + (first_block + 1 + word) * block_lines;
            const std::int32_t word_count = std::min(inner_count - word, blocks_per_word);
            std::uint64_t mixed = 0;
            for (std::int32_t group = 0; group < word_count; group += block_lines)
                for (std::size_t part = 0; part < parts; ++part) {
                    const std::int32_t block = group + static_cast<std::int32_t>(part * lanes);
                    const auto in_use = hn::RebindMask(
                        d, hn::Lt(hn::Add(hn::Iota(di, 0), hn::Set(di, block)), hn::Set(di, word_count)));
                    const auto all_lit = hn::And(in_use, hn::Ge(slope, hn::LoadU(d, highest + block)));
                    const auto some_lit = hn::And(in_use, hn::Ge(slope, hn::LoadU(d, lowest + block)));
                    mixed |= std::uint64_t{bits_of(hn::AndNot(all_lit, some_lit))} << block;
                    sums.add_count(all_lit, float{block_lines});
                    for (int c = 0; c < channels; ++c) {
                        sums.add(c, all_lit, of_block[c][part], hn::Set(d, series[c].block_sum));
                        hn::Store(of_block[c][part], d, &weights[c][block]);
                        of_block[c][part] = hn::Mul(of_block[c][part], hn::Set(d, series[c].of_group));
                    }
                }
            for (; mixed != 0; mixed &= mixed - 1) {
                const auto block = static_cast<std::size_t>(__builtin_ctzll(mixed));
                for (std::size_t part = 0; part < parts; ++part) {
                    const auto lit = hn::Ge(slope, hn::LoadU(d, slopes + block * block_lines + part * lanes));
                    sums.add_count(lit, 1.0f);
                    for (int c = 0; c < channels; ++c)
                        sums.add(c, lit, in_block[c][part], hn::Set(d, weights[c][block]));
                }
            }
        }
    }
    for (int c = 0; c < channels; ++c)
        result[c] = hn::GetLane(hn::SumOfLanes(d, sums.of_terms[c]));
    return hn::GetLane(hn::SumOfLanes(d, sums.count));
}

/// Whether any line of the blocks around [first, last] may be lit.
static HWY_INLINE bool some_lit(const RowView& row, float slope, std::int32_t first, std::int32_t last) {
    const std::int32_t first_block = (first - row.first) / block_lines, last_block = (last - row.first) / block_lines;
    for (std::int32_t block = first_block; block <= last_block; block += static_cast<std::int32_t>(lanes)) {
        const auto number = hn::Add(hn::Iota(di, 0), hn::Set(di, block));
        const auto in_use = hn::RebindMask(d, hn::Lt(number, hn::Set(di, last_block + 1)));
        if (!hn::AllFalse(d, hn::And(in_use, hn::Ge(hn::Set(d, slope), hn::LoadU(d, row.lowest + block)))))
            return true;
    }
    return false;
}

/// Pieces [begin, end) of a batch, all of one ray.
static void add_pieces(const Rows& rows, const PieceBatch& batch, std::size_t begin, std::size_t end, Rgb& radiance,
                       float& lit_length_m) {
    for (std::size_t i = begin; i < end; ++i) {
        const RowView row = rows.row(batch.slice[i]);
        const float slope = batch.slope[i];
        const auto add_end = [&](std::int32_t line, const auto& scattered, float length_m) {
            const float is_lit = slope >= row.slopes[line - row.first] ? 1.0f : 0.0f;
            lit_length_m += is_lit * length_m;
            for (std::size_t c = 0; c < 3; ++c)
                radiance[static_cast<int>(c)] += is_lit * scattered[c][i];
        };
        add_end(batch.line_before[i], batch.at_begin, batch.begin_length_m[i]);
        add_end(batch.line_after[i], batch.at_end, batch.end_length_m[i]);
        if (batch.whole_first[i] >= batch.whole_end[i])
            continue;
        const Stretch stretch{row, slope, batch.whole_first[i], batch.whole_end[i] - 1};
        Series series[3];
        for (std::size_t c = 0; c < 3; ++c)
            series[c] = {batch.powers(batch.of_line[c], i), batch.powers(batch.of_block[c], i), batch.of_group[c][i],
                         batch.block_sum[c][i], batch.last_block[c][i]};
        float sums[3];
        float count;
        if (batch.is_grey[i] != 0.0f) {
            count = sum_lit<1>(stretch, series, sums);
            sums[1] = sums[2] = sums[0];
        } else
            count = sum_lit<3>(stretch, series, sums);
        lit_length_m += count * batch.m_per_line[i];
        for (std::size_t c = 0; c < 3; ++c)
            radiance[static_cast<int>(c)] += batch.per_line[c][i] * sums[c];
    }
}

static void flush(const Rows& rows, PieceBatch& batch, std::span<Rgb> radiance, std::span<float> lit_length_m,
                  row_query::Unanswered& unanswered) {
    batch.evaluate();
    float unwanted_m = 0.0f;
    for (std::size_t begin = 0, end; begin < batch.count; begin = end) {
        bool is_steep = false;
        for (end = begin; end < batch.count && batch.ray[end] == batch.ray[begin]; ++end)
            is_steep = is_steep || batch.is_steep[end] != 0.0f;
        const std::uint32_t ray = batch.ray[begin];
        if (is_steep)
            unanswered.steep.push_back(ray);
        else
            add_pieces(rows, batch, begin, end, radiance[ray], lit_length_m.empty() ? unwanted_m : lit_length_m[ray]);
    }
    batch.count = 0;
}

static void append(PieceBatch& batch, const Asked& asked, std::size_t at, const RowExtent& extent,
                   const ScatterPiece& piece) {
    const std::size_t i = batch.count;
    batch.begin_m[i] = std::max(piece.near_m, asked.near_m[at]);
    batch.end_m[i] = std::min(piece.far_m, asked.far_m[at]);
    if (!(batch.begin_m[i] < batch.end_m[i]))
        return;
    batch.near_index[i] = asked.near_index[at];
    batch.ray_near_m[i] = asked.near_m[at];
    batch.m_per_line[i] = asked.m_per_line[at];
    batch.first_line[i] = asked.first_line[at];
    batch.last_line[i] = asked.last_line[at];
    batch.row_start[i] = static_cast<float>(extent.first);
    batch.piece_near_m[i] = piece.near_m;
    for (std::size_t c = 0; c < 3; ++c) {
        const auto channel = static_cast<int>(c);
        batch.source_per_m[c][i] = piece.source_per_m[channel];
        batch.depth_at_near[c][i] = piece.depth_at_near[channel];
        batch.depth_per_m[c][i] = piece.depth_per_m[channel];
    }
    batch.ray[i] = asked.first_of_call + static_cast<std::uint32_t>(asked.number[at]);
    batch.slice[i] = asked.slice[at];
    batch.slope[i] = asked.slope[at];
    ++batch.count;
}

/// Collects the pieces of rays until there are enough to evaluate.
static void add_alone(const Rows& rows, const Asked& asked, std::size_t at, const ScatterPiece* pieces,
                      PieceBatch& batch, std::span<Rgb> radiance, std::span<float> lit_length_m,
                      row_query::Unanswered& unanswered) {
    if (!some_lit(rows.row(asked.slice[at]), asked.slope[at], static_cast<std::int32_t>(asked.first_line[at]),
                  static_cast<std::int32_t>(asked.last_line[at])))
        return;
    const auto piece_count = static_cast<std::size_t>(asked.piece_count[at]);
    if (piece_count > PieceBatch::capacity) {
        unanswered.steep.push_back(asked.first_of_call + static_cast<std::uint32_t>(asked.number[at]));
        return;
    }
    if (batch.count + piece_count > PieceBatch::capacity)
        flush(rows, batch, radiance, lit_length_m, unanswered);
    const RowExtent& extent = rows.layout.rows[static_cast<std::size_t>(asked.slice[at])];
    for (std::size_t piece = 0; piece < piece_count; ++piece)
        append(batch, asked, at, extent, pieces[static_cast<std::size_t>(asked.first_piece[at]) + piece]);
}
} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
