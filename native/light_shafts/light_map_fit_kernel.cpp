// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/light_map_fit_kernel.hpp"
#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "light_shafts/light_map_fit_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "light_shafts/exp-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::light_map_kernel::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
/// Columns of texels side by side. Not 16: what is stored as 64 bytes and read again 4 at a time waits for the cache.
using Lines = hn::CappedTag<float, 8>;
using Colour = hn::FixedTag<float, 4>;
/// Four floats per column: as many columns as lanes are four vectors.
using Wide = hn::CappedTag<float, 16>;
static constexpr Lines lines;
static constexpr Colour colour;
static constexpr Wide wide;

/// Calls visit(index, offset, across, share) for each column of a line: the first of its two texels and the way to the other,
/// in floats, and the share of the other.
template <typename Visit>
static HWY_INLINE void for_columns(const Weights& weights, const MapLine& line, const Visit& visit) {
    const hn::RebindToSigned<Lines> offsets;
    const std::size_t lane_count = hn::Lanes(lines), column_count = line.count;
    const auto resolution = static_cast<std::int32_t>(weights.resolution),
               row = 4 * static_cast<std::int32_t>(weights.pitch);
    const std::int32_t per_line = line.goes_along_y ? row : 4, across = row + 4 - per_line;
    alignas(32) std::int32_t offset[8];
    alignas(32) float shares[8];
    const auto last = hn::Set(offsets, resolution - 2), across_in_floats = hn::Set(offsets, across);
    const auto lane = hn::Iota(lines, 0.0f);
    auto line_offset = hn::Mul(hn::Add(hn::Iota(offsets, 0), hn::Set(offsets, std::int32_t{line.first_line})),
                               hn::Set(offsets, per_line));
    const auto offset_step = hn::Set(offsets, static_cast<std::int32_t>(lane_count) * per_line);
    for (std::size_t begin = 0; begin < column_count; begin += lane_count) {
        const auto position = hn::MulAdd(hn::Add(lane, hn::Set(lines, static_cast<float>(begin))),
                                         hn::Set(lines, line.across_per_line), hn::Set(lines, line.across_at_first));
        const auto first = hn::Min(hn::Max(hn::ConvertTo(offsets, position), hn::Zero(offsets)), last);
        hn::Store(hn::Clamp(hn::Sub(position, hn::ConvertTo(lines, first)), hn::Zero(lines), hn::Set(lines, 1.0f)),
                  lines, shares);
        hn::Store(hn::Add(line_offset, hn::Mul(first, across_in_floats)), offsets, offset);
        line_offset = hn::Add(line_offset, offset_step);
        const std::size_t count = std::min(lane_count, column_count - begin);
#pragma GCC unroll 1
        for (std::size_t i = 0; i < count; ++i)
            visit(begin + i, offset[i], across, hn::Set(colour, shares[i]));
    }
}

/// Calls visit(four_samples, vector of weights) for each vector of a reader's samples; weights beyond its last are 0.
template <bool is_coloured, typename Visit>
static HWY_INLINE void for_samples(const Weights& weights, const LineReader& reader, float* samples,
                                   const Visit& visit) {
    const std::size_t lane_count = hn::Lanes(wide);
    float* const own = samples + std::size_t{4} * reader.offset;
    const std::uint16_t* const weight = weights.first + std::size_t{reader.first_weight} * (is_coloured ? 4 : 1);
    const hn::Rebind<std::uint16_t, Wide> rounded;
    const hn::RebindToSigned<Wide> places;
    const auto load = [&](std::size_t at, std::size_t count) HWY_ATTR {
        const auto in_units = hn::ConvertTo(wide, hn::PromoteTo(places, hn::LoadU(rounded, weight + at)));
        return hn::IfThenElseZero(hn::FirstN(wide, count - at), in_units);
    };
    if constexpr (is_coloured) {
        for (std::size_t at = 0; at < std::size_t{4} * reader.count; at += lane_count)
            visit(own + at, load(at, std::size_t{4} * reader.count));
    } else {
        const auto quarter = hn::Iota(places, 0);
        const auto quarter_lanes = static_cast<std::int32_t>(lane_count / 4);
        const auto of_four = hn::ShiftRight<2>(quarter);
        const auto at_first = hn::IndicesFromVec(wide, of_four),
                   at_second = hn::IndicesFromVec(wide, hn::Add(of_four, hn::Set(places, quarter_lanes))),
                   at_third = hn::IndicesFromVec(wide, hn::Add(of_four, hn::Set(places, 2 * quarter_lanes))),
                   at_fourth = hn::IndicesFromVec(wide, hn::Add(of_four, hn::Set(places, 3 * quarter_lanes)));
        for (std::size_t at = 0; at < reader.count; at += lane_count) {
            const auto w = load(at, reader.count);
            float* const four = own + 4 * at;
            visit(four, hn::TableLookupLanes(w, at_first));
            visit(four + lane_count, hn::TableLookupLanes(w, at_second));
            visit(four + 2 * lane_count, hn::TableLookupLanes(w, at_third));
            visit(four + 3 * lane_count, hn::TableLookupLanes(w, at_fourth));
        }
    }
}

template <bool is_coloured>
static void read_with(const Weights& weights, const MapLine& line, std::span<const LineReader> readers,
                      const float* map, float* samples, vec4* of_reader) {
    for_columns(weights, line, [&](std::size_t index, std::int32_t offset, std::int32_t across, auto share) HWY_ATTR {
        const auto low = hn::LoadU(colour, map + offset), high = hn::LoadU(colour, map + offset + across);
        hn::StoreU(hn::MulAdd(share, high, hn::NegMulAdd(share, low, low)), colour, samples + 4 * index);
    });
    for (std::size_t index = 0; index < readers.size(); ++index) {
        auto sum = hn::Zero(wide);
        for_samples<is_coloured>(weights, readers[index], samples, [&](const float* four, auto w) HWY_ATTR {
            sum = hn::MulAdd(w, hn::LoadU(wide, four), sum);
        });
        alignas(64) float lanes[16];
        hn::Store(sum, wide, lanes);
        auto total = hn::LoadU(colour, lanes);
        for (std::size_t at = 4; at < hn::Lanes(wide); at += 4)
            total = hn::Add(total, hn::LoadU(colour, lanes + at));
        hn::StoreU(hn::Mul(total, hn::Set(colour, readers[index].weight_unit)), colour, &of_reader[index].x);
    }
}
template <bool is_coloured, bool squares>
static void add_with(const Weights& weights, const MapLine& line, std::span<const LineReader> readers,
                     const vec4* ray_values, float* samples, float* map) {
    std::fill_n(samples, std::size_t{4} * line.count, 0.0f);
    for (const LineReader& reader : readers) {
        const float unit = squares ? reader.weight_unit * reader.weight_unit : reader.weight_unit;
        const auto value = hn::Mul(hn::LoadDup128(wide, &ray_values[reader.ray].x), hn::Set(wide, unit));
        for_samples<is_coloured>(weights, reader, samples, [&](float* four, auto w) HWY_ATTR {
            if constexpr (squares)
                w = hn::Mul(w, w);
            hn::StoreU(hn::MulAdd(w, value, hn::LoadU(wide, four)), wide, four);
        });
    }
    for_columns(weights, line, [&](std::size_t index, std::int32_t offset, std::int32_t across, auto share) HWY_ATTR {
        const auto sample = hn::LoadU(colour, samples + 4 * index);
        auto high = hn::Mul(share, sample), low = hn::Sub(sample, high);
        if constexpr (squares) {
            const auto rest = hn::Sub(hn::Set(colour, 1.0f), share);
            high = hn::Mul(share, high), low = hn::Mul(hn::Mul(rest, rest), sample);
        }
        float* const texel = map + offset;
        hn::StoreU(hn::Add(low, hn::LoadU(colour, texel)), colour, texel);
        hn::StoreU(hn::Add(high, hn::LoadU(colour, texel + across)), colour, texel + across);
    });
}

/// Of a line; whole vectors fit behind its last column.
static float* samples_of(const MapLine& line) {
    thread_local std::vector<float> samples;
    samples.resize(std::max(samples.size(), 4 * (std::size_t{line.count} + hn::Lanes(wide))));
    return samples.data();
}

void read_of(const Weights& weights, const MapLine& line, std::span<const LineReader> readers, const vec4* texels,
             vec4* of_reader) {
    weights.is_coloured ? read_with<true>(weights, line, readers, &texels->x, samples_of(line), of_reader)
                        : read_with<false>(weights, line, readers, &texels->x, samples_of(line), of_reader);
}
void add_of(const Weights& weights, const MapLine& line, std::span<const LineReader> readers, const vec4* ray_values,
            bool squares, vec4* texels) {
    float *const map = &texels->x, *const samples = samples_of(line);
    if (weights.is_coloured)
        squares ? add_with<true, true>(weights, line, readers, ray_values, samples, map)
                : add_with<true, false>(weights, line, readers, ray_values, samples, map);
    else
        squares ? add_with<false, true>(weights, line, readers, ray_values, samples, map)
                : add_with<false, false>(weights, line, readers, ray_values, samples, map);
}

void attenuate_of(std::span<const float> depth, std::span<float> amount) {
    const std::size_t lane_count = hn::Lanes(lines), whole = depth.size() / lane_count * lane_count;
    const auto attenuated = [](auto d, auto a)
                                HWY_ATTR { return hn::Mul(a, light_shafts::HWY_NAMESPACE::exp_of(lines, hn::Neg(d))); };
    for (std::size_t i = 0; i < whole; i += lane_count)
        hn::StoreU(attenuated(hn::LoadU(lines, &depth[i]), hn::LoadU(lines, &amount[i])), lines, &amount[i]);
    alignas(32) float rest[2][8] = {};
    std::copy(depth.begin() + static_cast<std::ptrdiff_t>(whole), depth.end(), rest[0]);
    std::copy(amount.begin() + static_cast<std::ptrdiff_t>(whole), amount.end(), rest[1]);
    hn::Store(attenuated(hn::Load(lines, rest[0]), hn::Load(lines, rest[1])), lines, rest[1]);
    std::copy_n(rest[1], depth.size() - whole, amount.begin() + static_cast<std::ptrdiff_t>(whole));
}
} // namespace tyndall::light_shafts::light_map_kernel::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::light_shafts::light_map_kernel {
HWY_EXPORT(read_of);
HWY_EXPORT(add_of);
HWY_EXPORT(attenuate_of);

void read(const Weights& weights, const MapLine& line, std::span<const LineReader> readers, const vec4* texels,
          vec4* of_reader) {
    HWY_DYNAMIC_DISPATCH(read_of)(weights, line, readers, texels, of_reader);
}
void add(const Weights& weights, const MapLine& line, std::span<const LineReader> readers, const vec4* ray_values,
         bool squares, vec4* texels) {
    HWY_DYNAMIC_DISPATCH(add_of)(weights, line, readers, ray_values, squares, texels);
}
void attenuate(std::span<const float> depth, std::span<float> amount) {
    HWY_DYNAMIC_DISPATCH(attenuate_of)(depth, amount);
}
} // namespace tyndall::light_shafts::light_map_kernel
#endif
