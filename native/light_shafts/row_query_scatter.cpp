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

/// sums[c] = sum of exp(-gain[c] * (line - first line of the first block)) over the lit lines; returns their number.
template <int channels>
HWY_INLINE std::int32_t sum_lit(const Stretch& stretch, const float* gain, float* sums) {
    const RowView& row = stretch.row;
    const V slope = hn::Set(d, stretch.slope);
    const std::int32_t first_block = (stretch.first - row.first) / block_lines,
                       last_block = (stretch.last - row.first) / block_lines;
    V in_block[channels][parts], whole[channels][parts], sum[channels];
    alignas(64) float of_block[channels][block_lines];
    float per_group[channels];
    for (int c = 0; c < channels; ++c) {
        for (std::size_t part = 0; part < parts; ++part) {
            const V line = hn::Iota(d, static_cast<float>(part * lanes));
            in_block[c][part] = exp_of(hn::Mul(hn::Set(d, -gain[c]), line));
            hn::Store(exp_of(hn::Mul(hn::Set(d, -16.0f * gain[c]), line)), d, &of_block[c][part * lanes]);
            whole[c][part] = hn::Zero(d);
        }
        sum[c] = hn::Zero(d);
        per_group[c] = of_block[c][15] * of_block[c][1];
    }
    std::int32_t count = 0;
    for (std::int32_t group = first_block; group <= last_block; group += 16) {
        const std::uint32_t used = last_block - group >= 15 ? 0xffffu : (1u << (last_block - group + 1)) - 1;
        std::uint32_t ends = group == first_block ? 1u : 0u; // blocks with lines that do not belong
        if (last_block - group < 16)
            ends |= 1u << (last_block - group);
        std::uint32_t lit = 0, dark = 0;
        for (std::size_t part = 0; part < parts; ++part) {
            const std::size_t at = static_cast<std::size_t>(group) + part * lanes;
            const auto is_lit = hn::Ge(slope, hn::LoadU(d, row.highest + at));
            lit |= bits_of(is_lit) << (part * lanes);
            dark |= bits_of(hn::Lt(slope, hn::LoadU(d, row.lowest + at))) << (part * lanes);
        }
        const std::uint32_t all_lit = lit & used & ~ends;
        if (all_lit != 0) {
            count += block_lines * __builtin_popcount(all_lit);
            for (std::size_t part = 0; part < parts; ++part) {
                const std::uint64_t part_bits = (all_lit >> (part * lanes)) & ((1u << lanes) - 1);
                const auto mask = hn::LoadMaskBits(d, reinterpret_cast<const std::uint8_t*>(&part_bits));
                for (int c = 0; c < channels; ++c)
                    whole[c][part] =
                        hn::Add(whole[c][part], hn::IfThenElseZero(mask, hn::Load(d, &of_block[c][part * lanes])));
            }
        }
        for (std::uint32_t left = used & (ends | ~(lit | dark)); left != 0; left &= left - 1) {
            const auto block = static_cast<std::uint32_t>(__builtin_ctz(left));
            const std::int32_t offset = (group + static_cast<std::int32_t>(block)) * block_lines;
            const bool is_end = ends >> block & 1;
            for (std::size_t part = 0; part < parts; ++part) {
                auto mask = hn::Ge(slope, hn::LoadU(d, row.slopes + offset + part * lanes));
                if (is_end) {
                    const auto line = hn::Iota(di, row.first + offset + static_cast<std::int32_t>(part * lanes));
                    const auto belongs = hn::And(hn::Gt(line, hn::Set(di, stretch.first - 1)),
                                                 hn::Lt(line, hn::Set(di, stretch.last + 1)));
                    mask = hn::And(mask, hn::RebindMask(d, belongs));
                }
                count += static_cast<std::int32_t>(hn::CountTrue(d, mask));
                for (int c = 0; c < channels; ++c)
                    sum[c] =
                        hn::MulAdd(hn::IfThenElseZero(mask, in_block[c][part]), hn::Set(d, of_block[c][block]), sum[c]);
            }
        }
        if (last_block - group >= 16)
            for (int c = 0; c < channels; ++c)
                for (std::size_t part = 0; part < parts; ++part)
                    hn::Store(hn::Mul(hn::Load(d, &of_block[c][part * lanes]), hn::Set(d, per_group[c])), d,
                              &of_block[c][part * lanes]);
    }
    for (int c = 0; c < channels; ++c) {
        V block_sum = in_block[c][0], total = whole[c][0];
        for (std::size_t part = 1; part < parts; ++part) {
            block_sum = hn::Add(block_sum, in_block[c][part]);
            total = hn::Add(total, whole[c][part]);
        }
        sum[c] = hn::MulAdd(total, hn::SumOfLanes(d, block_sum), sum[c]);
        sums[c] = hn::GetLane(hn::SumOfLanes(d, sum[c]));
    }
    return count;
}

/// sinh(x) / x for the mean of an exponential over a line around its middle.
static HWY_INLINE float mean_around_middle(float x) {
    return std::abs(x) < 0.1f ? 1.0f + x * x * (1.0f / 6.0f + x * x * (1.0f / 120.0f)) : std::sinh(x) / x;
}

/// One ray in its row: distances are linear in line numbers.
struct RayInRow {
    Stretch stretch;
    float near_index, near_m, far_m, m_per_line, lines_per_m;
    [[nodiscard]] float distance(float index) const { return near_m + (index - near_index) * m_per_line; }
};

/// False where a term of the series would leave the range of floats.
static bool add_piece(const RayInRow& ray, const ScatterPiece& piece, Rgb& radiance, float& lit_length_m) {
    const float piece_near = std::max(piece.near_m, ray.near_m), piece_far = std::min(piece.far_m, ray.far_m);
    if (!(piece_near < piece_far))
        return true;
    const float first_index = ray.near_index + (piece_near - ray.near_m) * ray.lines_per_m,
                end_index = ray.near_index + (piece_far - ray.near_m) * ray.lines_per_m;
    const std::int32_t row_first = ray.stretch.first, row_last = ray.stretch.last;
    // Whole lines; what is left at both ends belongs to the line before and after, or to the ray's outermost one.
    Stretch whole = ray.stretch;
    whole.first = std::clamp(static_cast<std::int32_t>(std::ceil(first_index)), row_first, row_last + 1);
    whole.last = std::clamp(static_cast<std::int32_t>(std::floor(end_index)), row_first, row_last + 1) - 1;
    float gain[3], sums[3], end_near[2], end_far[2];
    bool is_grey = true;
    const float block_m =
        ray.distance(static_cast<float>(whole.row.first + (whole.first - whole.row.first) / block_lines * block_lines));
    alignas(64) float exponent[16] = {}, value[16];
    if (whole.first <= whole.last) {
        end_near[0] = piece_near;
        end_far[0] = std::min(ray.distance(static_cast<float>(whole.first)), piece_far);
        end_near[1] = std::max(ray.distance(static_cast<float>(whole.last + 1)), piece_near);
        end_far[1] = piece_far;
    } else {
        const float border = std::clamp(ray.distance(static_cast<float>(whole.first)), piece_near, piece_far);
        end_near[0] = piece_near;
        end_far[0] = end_near[1] = border;
        end_far[1] = piece_far;
    }
    for (int c = 0; c < 3; ++c) {
        gain[c] = piece.depth_per_m[c] * ray.m_per_line;
        if (std::abs(gain[c]) > 2.0f || gain[c] * static_cast<float>(row_last - row_first) < -40.0f)
            return false;
        is_grey = is_grey && gain[c] == gain[0] && piece.depth_at_near[c] == piece.depth_at_near[0];
        const auto depth_at = [&](float t) {
            return piece.depth_at_near[c] + piece.depth_per_m[c] * (t - piece.near_m);
        };
        exponent[c] = -depth_at(block_m + 0.5f * ray.m_per_line);
        exponent[4 + c] = -depth_at(0.5f * (end_near[0] + end_far[0]));
        exponent[8 + c] = -depth_at(0.5f * (end_near[1] + end_far[1]));
    }
    for (std::size_t i = 0; i < 16; i += lanes)
        hn::Store(exp_of(hn::Load(d, exponent + i)), d, value + i);
    const RowView& row = whole.row;
    for (std::int32_t end = 0; end < 2; ++end) {
        const std::int32_t line = std::clamp(end == 0 ? whole.first - 1 : whole.last + 1, row_first, row_last);
        const float length_m = end_far[end] - end_near[end];
        if (!(length_m > 0.0f) || !(ray.stretch.slope >= row.slopes[line - row.first]))
            continue;
        lit_length_m += length_m;
        for (int c = 0; c < 3; ++c)
            radiance[c] += piece.source_per_m[c] * length_m * value[4 * (end + 1) + c] *
                           mean_around_middle(0.5f * piece.depth_per_m[c] * length_m);
    }
    if (whole.first > whole.last)
        return true;
    const std::int32_t count = is_grey ? sum_lit<1>(whole, gain, sums) : sum_lit<3>(whole, gain, sums);
    lit_length_m += static_cast<float>(count) * ray.m_per_line;
    for (int c = 0; c < 3; ++c)
        radiance[c] += piece.source_per_m[c] * ray.m_per_line * value[c] * mean_around_middle(0.5f * gain[c]) *
                       sums[is_grey ? 0 : c];
    return true;
}

void add_scattered_of(const Rows& rows, std::span<const ViewRay> rays, const PieceRows& pieces, std::span<Rgb> radiance,
                      std::span<float> lit_length_m, row_query::Unanswered& unanswered) {
    PlacedRays placed;
    for (std::size_t start = 0; start < rays.size(); start += PlacedRays::capacity) {
        const auto block = rays.subspan(start, std::min(PlacedRays::capacity, rays.size() - start));
        place_rays(rows.layout.frame, block, placed);
        for (std::size_t i = 0; i < block.size(); ++i) {
            const auto index = static_cast<std::uint32_t>(start + i);
            if (!(block[i].near_m < block[i].far_m) || pieces.first[index] == pieces.first[index + 1])
                continue;
            RowHit hit;
            const Cover cover = find_row(rows.layout, placed, i, hit);
            if (cover != Cover::Rows) {
                (cover == Cover::NearEpipole ? unanswered.near_epipole : unanswered.outside).push_back(index);
                continue;
            }
            const float m_per_line = rows.layout.line_step / placed.radial_per_m[i];
            const RayInRow ray{.stretch = {rows.row(hit.slice), placed.slope[i], hit.first, hit.last},
                               .near_index = hit.near_index,
                               .near_m = block[i].near_m,
                               .far_m = block[i].far_m,
                               .m_per_line = m_per_line,
                               .lines_per_m = 1.0f / m_per_line};
            Rgb scattered(0.0f);
            float length_m = 0.0f;
            bool is_answered = true;
            for (std::uint32_t p = pieces.first[index]; is_answered && p < pieces.first[index + 1]; ++p)
                is_answered = add_piece(ray, pieces.pieces[p], scattered, length_m);
            if (!is_answered) {
                unanswered.steep.push_back(index);
                continue;
            }
            radiance[index] += scattered;
            lit_length_m[index] += length_m;
        }
    }
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
