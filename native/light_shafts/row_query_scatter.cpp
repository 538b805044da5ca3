// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/row_query_scatter.hpp"
#include <array>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "light_shafts/row_query_scatter.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "light_shafts/row_query_lane-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
using V = hn::Vec<LineTag>;
static constexpr LineTag d;
static constexpr hn::RebindToSigned<LineTag> di;
static constexpr std::size_t lanes = hn::MaxLanes(d), parts = block_lines / lanes;

/// exp(x), relative error 3e-7; 0 below -87, no more than exp(80).
/// Based on: Cephes expf (Moshier).
static HWY_INLINE V exp_of(V x) {
    x = hn::Min(hn::Max(x, hn::Set(d, -87.0f)), hn::Set(d, 80.0f));
    const V n = hn::Round(hn::Mul(x, hn::Set(d, 1.44269504f)));
    V f = hn::NegMulAdd(n, hn::Set(d, 0.693359375f), x);
    f = hn::MulAdd(n, hn::Set(d, 2.12194440e-4f), f);
    V p = hn::MulAdd(hn::Set(d, 1.9875691500e-4f), f, hn::Set(d, 1.3981999507e-3f));
    p = hn::MulAdd(p, f, hn::Set(d, 8.3334519073e-3f));
    p = hn::MulAdd(p, f, hn::Set(d, 4.1665795894e-2f));
    p = hn::MulAdd(p, f, hn::Set(d, 1.6666665459e-1f));
    p = hn::MulAdd(p, f, hn::Set(d, 5.0000001201e-1f));
    p = hn::Add(hn::MulAdd(p, hn::Mul(f, f), f), hn::Set(d, 1.0f));
    const auto exponent = hn::ShiftLeft<23>(hn::Add(hn::ConvertTo(di, n), hn::Set(di, 127)));
    return hn::Mul(p, hn::BitCast(d, exponent));
}

/// Lines [first, last] of a row, all of them whole, for one slope.
struct Stretch {
    RowView row;
    float slope;
    std::int32_t first, last;
};
/// Of one channel: the series' terms are exp(-gain * line), counted from the first line of the first block.
struct Series {
    float gain;
    float block_sum;  ///< Of a block's 16 terms.
    float last_block; ///< exp(-gain * 16 * blocks before the last one).
};

/// The lit lines of one block, without those outside [first, last].
static HWY_INLINE hn::Mask<LineTag> lit_in_end(const Stretch& stretch, V slope, std::int32_t block, std::int32_t first,
                                               std::size_t part) {
    const std::int32_t offset = block * block_lines + static_cast<std::int32_t>(part * lanes);
    // Not Iota(first): Highway 1.0 builds that lane by lane, and the load of it waits for all the stores.
    const auto line = hn::Add(hn::Iota(di, 0), hn::Set(di, stretch.row.first + offset));
    const auto belongs = hn::And(hn::Gt(line, hn::Set(di, first - 1)), hn::Lt(line, hn::Set(di, stretch.last + 1)));
    return hn::And(hn::Ge(slope, hn::LoadU(d, stretch.row.slopes + offset)), hn::RebindMask(d, belongs));
}

/// sums[c]: of the terms of the lit lines; returns their number. No branch depends on where the stretch begins and ends:
/// a branch that is guessed wrong costs as much as four blocks.
template <int channels>
HWY_INLINE std::int32_t sum_lit(const Stretch& stretch, const Series* series, float* sums) {
    const RowView& row = stretch.row;
    const V slope = hn::Set(d, stretch.slope);
    const std::int32_t first_block = (stretch.first - row.first) / block_lines,
                       last_block = (stretch.last - row.first) / block_lines;
    const std::int32_t after_first = row.first + (first_block + 1) * block_lines;
    V in_block[channels][parts], sum[channels];
    std::int32_t count = 0;
    for (int c = 0; c < channels; ++c)
        sum[c] = hn::Zero(d);
    for (std::size_t part = 0; part < parts; ++part) {
        const V line = hn::Iota(d, static_cast<float>(part * lanes));
        const auto at_first = lit_in_end(stretch, slope, first_block, stretch.first, part),
                   at_last = lit_in_end(stretch, slope, last_block, std::max(stretch.first, after_first), part);
        count += static_cast<std::int32_t>(hn::CountTrue(d, at_first) + hn::CountTrue(d, at_last));
        for (int c = 0; c < channels; ++c) {
            in_block[c][part] = exp_of(hn::Mul(hn::Set(d, -series[c].gain), line));
            sum[c] = hn::Add(sum[c], hn::IfThenElseZero(at_first, in_block[c][part]));
            sum[c] =
                hn::MulAdd(hn::IfThenElseZero(at_last, in_block[c][part]), hn::Set(d, series[c].last_block), sum[c]);
        }
    }
    const std::int32_t inner_count = last_block - first_block - 1;
    if (inner_count > 0) {
        alignas(64) float of_block[channels][block_lines];
        float per_group[channels];
        for (int c = 0; c < channels; ++c) {
            for (std::size_t part = 0; part < parts; ++part)
                hn::Store(exp_of(hn::Mul(hn::Set(d, -16.0f * series[c].gain),
                                         hn::Iota(d, static_cast<float>(part * lanes + 1)))),
                          d, &of_block[c][part * lanes]);
            per_group[c] = of_block[c][15];
        }
        for (std::int32_t done = 0;; done += 16) {
            const std::size_t group = static_cast<std::size_t>(first_block + 1 + done);
            const std::uint32_t used = inner_count - done >= 16 ? 0xffffu : (1u << (inner_count - done)) - 1;
            std::uint32_t mixed = 0;
            for (std::size_t part = 0; part < parts; ++part) {
                const std::uint64_t part_used = (used >> (part * lanes)) & ((1u << lanes) - 1);
                const auto in_use = hn::LoadMaskBits(d, reinterpret_cast<const std::uint8_t*>(&part_used));
                const std::size_t at = group + part * lanes;
                const auto all_lit = hn::And(in_use, hn::Ge(slope, hn::LoadU(d, row.highest + at)));
                const auto some_lit = hn::And(in_use, hn::Ge(slope, hn::LoadU(d, row.lowest + at)));
                mixed |= bits_of(hn::AndNot(all_lit, some_lit)) << (part * lanes);
                count += block_lines * static_cast<std::int32_t>(hn::CountTrue(d, all_lit));
                for (int c = 0; c < channels; ++c)
                    sum[c] = hn::MulAdd(hn::IfThenElseZero(all_lit, hn::Load(d, &of_block[c][part * lanes])),
                                        hn::Set(d, series[c].block_sum), sum[c]);
            }
            for (; mixed != 0; mixed &= mixed - 1) {
                const auto block = static_cast<std::size_t>(__builtin_ctz(mixed));
                for (std::size_t part = 0; part < parts; ++part) {
                    const auto lit =
                        hn::Ge(slope, hn::LoadU(d, row.slopes + (group + block) * block_lines + part * lanes));
                    count += static_cast<std::int32_t>(hn::CountTrue(d, lit));
                    for (int c = 0; c < channels; ++c)
                        sum[c] = hn::MulAdd(hn::IfThenElseZero(lit, in_block[c][part]), hn::Set(d, of_block[c][block]),
                                            sum[c]);
                }
            }
            if (inner_count - done <= 16)
                break;
            for (int c = 0; c < channels; ++c)
                for (std::size_t part = 0; part < parts; ++part)
                    hn::Store(hn::Mul(hn::Load(d, &of_block[c][part * lanes]), hn::Set(d, per_group[c])), d,
                              &of_block[c][part * lanes]);
        }
    }
    for (int c = 0; c < channels; ++c)
        sums[c] = hn::GetLane(hn::SumOfLanes(d, sum[c]));
    return count;
}

/// sinh(x) / x, the mean of an exponential over a stretch around its middle; 1e-6 up to 1.5.
static HWY_INLINE V mean_around_middle(V x) {
    const V z = hn::Mul(x, x);
    V p = hn::MulAdd(z, hn::Set(d, 1.0f / 362880), hn::Set(d, 1.0f / 5040));
    p = hn::MulAdd(p, z, hn::Set(d, 1.0f / 120));
    p = hn::MulAdd(p, z, hn::Set(d, 1.0f / 6));
    return hn::MulAdd(p, z, hn::Set(d, 1.0f));
}

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
    alignas(64) std::array<Column<float>, 3> gain, block_sum, last_block, per_line, at_begin, at_end;
    alignas(64) Column<float> begin_length_m, end_length_m, is_steep, is_grey;

    void evaluate();
};

void PieceBatch::evaluate() {
    const V one = hn::Set(d, 1.0f), half = hn::Set(d, 0.5f);
    for (std::size_t i = 0; i < count; i += lanes) {
        const auto in = [&](const Column<float>& column) { return hn::Load(d, &column[i]); };
        const V ray_near = in(ray_near_m), start = in(near_index), step = in(m_per_line), begin = in(begin_m),
                end = in(end_m), first = in(first_line), past = hn::Add(in(last_line), one),
                own_near = in(piece_near_m);
        const V per_m = hn::Div(one, step);
        const auto index_at = [&](V t) { return hn::MulAdd(hn::Sub(t, ray_near), per_m, start); };
        const auto distance_at = [&](V index) { return hn::MulAdd(hn::Sub(index, start), step, ray_near); };
        const auto clamped = [](V value, V low, V high) { return hn::Min(hn::Max(value, low), high); };
        const V whole_begin = clamped(hn::Ceil(index_at(begin)), first, past);
        const V whole_past = clamped(hn::Floor(index_at(end)), first, past);
        const V left = clamped(distance_at(whole_begin), begin, end);
        const V right = hn::Max(clamped(distance_at(whole_past), begin, end), left);
        const V begin_length = hn::Sub(left, begin), end_length = hn::Sub(end, right);
        const V in_row = hn::Sub(whole_begin, in(row_start));
        const V block_line = hn::MulAdd(hn::Floor(hn::Mul(in_row, hn::Set(d, 1.0f / block_lines))),
                                        hn::Set(d, float{block_lines}), in(row_start));
        const V lines_before_last =
            hn::Mul(hn::Floor(hn::Mul(hn::Sub(hn::Sub(whole_past, one), block_line), hn::Set(d, 1.0f / block_lines))),
                    hn::Set(d, float{block_lines}));
        const V block_middle = hn::MulAdd(half, step, distance_at(block_line));
        const V begin_middle = hn::MulAdd(half, begin_length, begin), end_middle = hn::NegMulAdd(half, end_length, end);
        hn::Store(begin_length, d, &begin_length_m[i]);
        hn::Store(end_length, d, &end_length_m[i]);
        hn::Store(hn::ConvertTo(di, whole_begin), di, &whole_first[i]);
        hn::Store(hn::ConvertTo(di, whole_past), di, &whole_end[i]);
        hn::Store(hn::ConvertTo(di, clamped(hn::Sub(whole_begin, one), first, in(last_line))), di, &line_before[i]);
        hn::Store(hn::ConvertTo(di, clamped(whole_past, first, in(last_line))), di, &line_after[i]);
        const auto same_as_red = [&](std::size_t c) {
            return hn::And(hn::Eq(in(depth_per_m[c]), in(depth_per_m[0])),
                           hn::Eq(in(depth_at_near[c]), in(depth_at_near[0])));
        };
        const auto is_same = hn::And(same_as_red(1), same_as_red(2));
        hn::Store(hn::IfThenElseZero(is_same, one), d, &is_grey[i]);
        const bool shares_red = hn::AllTrue(d, hn::And(is_same, hn::Gt(in(source_per_m[0]), hn::Set(d, 1e-30f))));
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
                    hn::Mul(exp_of(hn::Neg(depth)), mean_around_middle(hn::Mul(half, hn::Mul(slope_c, length)))));
            };
            const V q = exp_of(hn::Neg(line_gain)), q2 = hn::Mul(q, q), q4 = hn::Mul(q2, q2), q8 = hn::Mul(q4, q4);
            hn::Store(line_gain, d, &gain[c][i]);
            hn::Store(hn::Mul(hn::Mul(hn::Add(one, q), hn::Add(one, q2)), hn::Mul(hn::Add(one, q4), hn::Add(one, q8))),
                      d, &block_sum[c][i]);
            hn::Store(exp_of(hn::Neg(hn::Mul(line_gain, lines_before_last))), d, &last_block[c][i]);
            hn::Store(mean_at(block_middle, step), d, &per_line[c][i]);
            hn::Store(mean_at(begin_middle, begin_length), d, &at_begin[c][i]);
            hn::Store(mean_at(end_middle, end_length), d, &at_end[c][i]);
            const auto overflows = hn::Or(hn::Gt(hn::Abs(line_gain), hn::Set(d, 2.0f)),
                                          hn::Lt(hn::Mul(line_gain, hn::Sub(past, first)), hn::Set(d, -40.0f)));
            steep = hn::IfThenElse(overflows, one, steep);
        }
        hn::Store(steep, d, &is_steep[i]);
    }
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
            series[c] = {batch.gain[c][i], batch.block_sum[c][i], batch.last_block[c][i]};
        float sums[3];
        std::int32_t count;
        if (batch.is_grey[i] != 0.0f) {
            count = sum_lit<1>(stretch, series, sums);
            sums[1] = sums[2] = sums[0];
        } else
            count = sum_lit<3>(stretch, series, sums);
        lit_length_m += static_cast<float>(count) * batch.m_per_line[i];
        for (std::size_t c = 0; c < 3; ++c)
            radiance[static_cast<int>(c)] += batch.per_line[c][i] * sums[c];
    }
}

static void flush(const Rows& rows, PieceBatch& batch, std::span<Rgb> radiance, std::span<float> lit_length_m,
                  row_query::Unanswered& unanswered) {
    batch.evaluate();
    for (std::size_t begin = 0, end; begin < batch.count; begin = end) {
        bool is_steep = false;
        for (end = begin; end < batch.count && batch.ray[end] == batch.ray[begin]; ++end)
            is_steep = is_steep || batch.is_steep[end] != 0.0f;
        const std::uint32_t ray = batch.ray[begin];
        if (is_steep)
            unanswered.steep.push_back(ray);
        else
            add_pieces(rows, batch, begin, end, radiance[ray], lit_length_m[ray]);
    }
    batch.count = 0;
}

static void append(PieceBatch& batch, const RowHit& hit, const RowExtent& extent, const PlacedRays& placed,
                   std::size_t in_block, const ViewRay& ray, std::uint32_t index, float m_per_line,
                   const ScatterPiece& piece) {
    const std::size_t i = batch.count;
    batch.begin_m[i] = std::max(piece.near_m, ray.near_m);
    batch.end_m[i] = std::min(piece.far_m, ray.far_m);
    if (!(batch.begin_m[i] < batch.end_m[i]))
        return;
    batch.near_index[i] = hit.near_index;
    batch.ray_near_m[i] = ray.near_m;
    batch.m_per_line[i] = m_per_line;
    batch.first_line[i] = static_cast<float>(hit.first);
    batch.last_line[i] = static_cast<float>(hit.last);
    batch.row_start[i] = static_cast<float>(extent.first);
    batch.piece_near_m[i] = piece.near_m;
    for (std::size_t c = 0; c < 3; ++c) {
        const auto channel = static_cast<int>(c);
        batch.source_per_m[c][i] = piece.source_per_m[channel];
        batch.depth_at_near[c][i] = piece.depth_at_near[channel];
        batch.depth_per_m[c][i] = piece.depth_per_m[channel];
    }
    batch.ray[i] = index;
    batch.slice[i] = hit.slice;
    batch.slope[i] = placed.slope[in_block];
    ++batch.count;
}

void add_scattered_of(const Rows& rows, std::span<const ViewRay> rays, const PieceRows& pieces, std::span<Rgb> radiance,
                      std::span<float> lit_length_m, row_query::Unanswered& unanswered) {
    PlacedRays placed;
    PieceBatch batch{};
    for (std::size_t start = 0; start < rays.size(); start += PlacedRays::capacity) {
        const auto block = rays.subspan(start, std::min(PlacedRays::capacity, rays.size() - start));
        place_rays(rows.layout.frame, block, placed);
        for (std::size_t i = 0; i < block.size(); ++i) {
            const auto index = static_cast<std::uint32_t>(start + i);
            const std::uint32_t first_piece = pieces.first[index], end_piece = pieces.first[index + 1];
            if (!(block[i].near_m < block[i].far_m) || first_piece == end_piece)
                continue;
            RowHit hit;
            const Cover cover = find_row(rows.layout, placed, i, hit);
            if (cover != Cover::Rows) {
                (cover == Cover::NearEpipole ? unanswered.near_epipole : unanswered.outside).push_back(index);
                continue;
            }
            if (end_piece - first_piece > PieceBatch::capacity) {
                unanswered.steep.push_back(index);
                continue;
            }
            if (batch.count + (end_piece - first_piece) > PieceBatch::capacity)
                flush(rows, batch, radiance, lit_length_m, unanswered);
            const RowExtent& extent = rows.layout.rows[static_cast<std::size_t>(hit.slice)];
            const float m_per_line = rows.layout.line_step / placed.radial_per_m[i];
            for (std::uint32_t p = first_piece; p < end_piece; ++p)
                append(batch, hit, extent, placed, i, block[i], index, m_per_line, pieces.pieces[p]);
        }
    }
    flush(rows, batch, radiance, lit_length_m, unanswered);
}
} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::light_shafts {
HWY_EXPORT(add_scattered_of);
} // namespace tyndall::light_shafts

namespace tyndall::light_shafts::row_query {
void add_scattered(const slope_rows::Rows& rows, std::span<const ViewRay> rays, const PieceRows& pieces,
                   std::span<Rgb> radiance, std::span<float> lit_length_m, Unanswered& unanswered) {
    HWY_DYNAMIC_DISPATCH(add_scattered_of)(rows, rays, pieces, radiance, lit_length_m, unanswered);
}
} // namespace tyndall::light_shafts::row_query
#endif
