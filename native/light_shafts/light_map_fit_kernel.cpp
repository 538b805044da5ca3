// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/light_map_fit_kernel.hpp"
#include <algorithm>
#include <array>

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
using Four = hn::FixedTag<float, 4>; ///< A texel's channels, or one channel of four columns.
using Wide = hn::CappedTag<float, 16>;
static constexpr Lines lines;
static constexpr Four four;
static constexpr Wide wide;
using FourTexels = std::array<hn::Vec<Four>, 4>;

/// What a line's columns have, channel by channel, so that a weight meets as many samples as it has channels. Behind the last
/// column there is room for a whole vector.
struct Samples {
    std::array<float*, 3> channels;
    std::size_t stride;
};
static Samples samples_of(const MapLine& line) {
    thread_local std::vector<float> samples;
    const std::size_t stride = line.count + hn::MaxLanes(wide);
    samples.resize(std::max(samples.size(), 3 * stride));
    return {{samples.data(), samples.data() + stride, samples.data() + 2 * stride}, stride};
}

static HWY_INLINE void store_texels(const Samples& samples, std::size_t at, const FourTexels& texels) {
    const auto even_lower = hn::InterleaveLower(four, texels[0], texels[2]),
               odd_lower = hn::InterleaveLower(four, texels[1], texels[3]);
    hn::StoreU(hn::InterleaveLower(four, even_lower, odd_lower), four, samples.channels[0] + at);
    hn::StoreU(hn::InterleaveUpper(four, even_lower, odd_lower), four, samples.channels[1] + at);
    const auto even_upper = hn::InterleaveUpper(four, texels[0], texels[2]),
               odd_upper = hn::InterleaveUpper(four, texels[1], texels[3]);
    hn::StoreU(hn::InterleaveLower(four, even_upper, odd_upper), four, samples.channels[2] + at);
}
static HWY_INLINE FourTexels load_texels(const Samples& samples, std::size_t at) {
    const auto red = hn::LoadU(four, samples.channels[0] + at), green = hn::LoadU(four, samples.channels[1] + at),
               blue = hn::LoadU(four, samples.channels[2] + at), none = hn::Zero(four);
    const auto first = hn::InterleaveLower(four, red, blue), second = hn::InterleaveLower(four, green, none),
               third = hn::InterleaveUpper(four, red, blue), fourth = hn::InterleaveUpper(four, green, none);
    return {hn::InterleaveLower(four, first, second), hn::InterleaveUpper(four, first, second),
            hn::InterleaveLower(four, third, fourth), hn::InterleaveUpper(four, third, fourth)};
}

/// Calls visit(index, offsets, across, shares) for each four columns of a line: the first of their two texels and the way to
/// the other, in floats, and the share of the other. Behind the last column they repeat it.
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
    const auto last_column = hn::Set(offsets, static_cast<std::int32_t>(column_count) - 1);
    auto lane = hn::Iota(offsets, 0);
    for (std::size_t begin = 0; begin < column_count; begin += lane_count) {
        const auto column = hn::Min(lane, last_column);
        lane = hn::Add(lane, hn::Set(offsets, static_cast<std::int32_t>(lane_count)));
        const auto position = hn::MulAdd(hn::ConvertTo(lines, column), hn::Set(lines, line.across_per_line),
                                         hn::Set(lines, line.across_at_first));
        const auto first = hn::Min(hn::Max(hn::ConvertTo(offsets, position), hn::Zero(offsets)), last);
        hn::Store(hn::Clamp(hn::Sub(position, hn::ConvertTo(lines, first)), hn::Zero(lines), hn::Set(lines, 1.0f)),
                  lines, shares);
        const auto of_line = hn::Add(column, hn::Set(offsets, std::int32_t{line.first_line}));
        hn::Store(hn::Add(hn::Mul(of_line, hn::Set(offsets, per_line)), hn::Mul(first, across_in_floats)), offsets,
                  offset);
        for (std::size_t i = 0; i < lane_count && begin + i < column_count; i += 4)
            visit(begin + i, offset + i, across, shares + i);
    }
}

/// Calls visit(place of the first sample, weights of red, green and blue) for each vector of a reader's samples; weights
/// beyond its last are 0.
template <bool is_coloured, typename Visit>
static HWY_INLINE void for_samples(const Weights& weights, const LineReader& reader, const Visit& visit) {
    const std::uint16_t* const own = weights.first + std::size_t{reader.first_weight} * (is_coloured ? 4 : 1);
    const hn::Rebind<std::uint16_t, Wide> rounded;
    const hn::RebindToSigned<Wide> whole;
    const std::size_t lane_count = hn::Lanes(wide), count = reader.count, full = count / lane_count * lane_count;
    const auto visit_at = [&](std::size_t at, const auto& keep) HWY_ATTR {
        const auto in_units = [&](auto weight)
                                  HWY_ATTR { return keep(hn::ConvertTo(wide, hn::PromoteTo(whole, weight))); };
        if constexpr (is_coloured) {
            hn::Vec<decltype(rounded)> red, green, blue, unused;
            hn::LoadInterleaved4(rounded, own + 4 * at, red, green, blue, unused);
            visit(reader.offset + at, in_units(red), in_units(green), in_units(blue));
        } else {
            const auto weight = in_units(hn::LoadU(rounded, own + at));
            visit(reader.offset + at, weight, weight, weight);
        }
    };
    for (std::size_t at = 0; at < full; at += lane_count)
        visit_at(at, [](auto weight) HWY_ATTR { return weight; });
    if (full < count)
        visit_at(full,
                 [&](auto weight) HWY_ATTR { return hn::IfThenElseZero(hn::FirstN(wide, count - full), weight); });
}

template <bool is_coloured>
static void read_with(const Weights& weights, const MapLine& line, std::span<const LineReader> readers,
                      const float* map, vec4* of_reader) {
    const Samples samples = samples_of(line);
    for_columns(weights, line,
                [&](std::size_t at, const std::int32_t* offsets, std::int32_t across, const float* shares) HWY_ATTR {
                    const auto read = [&](std::size_t i) HWY_ATTR {
                        const auto low = hn::LoadU(four, map + offsets[i]),
                                   high = hn::LoadU(four, map + offsets[i] + across), share = hn::Set(four, shares[i]);
                        return hn::MulAdd(share, high, hn::NegMulAdd(share, low, low));
                    };
                    store_texels(samples, at, {read(0), read(1), read(2), read(3)});
                });
    for (std::size_t index = 0; index < readers.size(); ++index) {
        auto red = hn::Zero(wide), green = red, blue = red;
        for_samples<is_coloured>(weights, readers[index],
                                 [&](std::size_t at, auto w_red, auto w_green, auto w_blue) HWY_ATTR {
                                     red = hn::MulAdd(w_red, hn::LoadU(wide, samples.channels[0] + at), red);
                                     green = hn::MulAdd(w_green, hn::LoadU(wide, samples.channels[1] + at), green);
                                     blue = hn::MulAdd(w_blue, hn::LoadU(wide, samples.channels[2] + at), blue);
                                 });
        const auto total = [](auto lanes) HWY_ATTR { return hn::GetLane(hn::SumOfLanes(wide, lanes)); };
        const vec3 sum(total(red), total(green), total(blue));
        of_reader[index] = vec4(readers[index].weight_unit * sum, 0.0f);
    }
}
template <bool is_coloured, bool squares>
static void add_with(const Weights& weights, const MapLine& line, std::span<const LineReader> readers,
                     const vec4* ray_values, float* map) {
    const Samples samples = samples_of(line);
    std::fill_n(samples.channels[0], 3 * samples.stride, 0.0f);
    for (const LineReader& reader : readers) {
        const float unit = squares ? reader.weight_unit * reader.weight_unit : reader.weight_unit;
        const vec4& value = ray_values[reader.ray];
        const auto red = hn::Set(wide, unit * value.x), green = hn::Set(wide, unit * value.y),
                   blue = hn::Set(wide, unit * value.z);
        const auto add = [](float* channel, auto w, auto of_channel) HWY_ATTR {
            if constexpr (squares)
                w = hn::Mul(w, w);
            hn::StoreU(hn::MulAdd(w, of_channel, hn::LoadU(wide, channel)), wide, channel);
        };
        for_samples<is_coloured>(weights, reader, [&](std::size_t at, auto w_red, auto w_green, auto w_blue) HWY_ATTR {
            add(samples.channels[0] + at, w_red, red);
            add(samples.channels[1] + at, w_green, green);
            add(samples.channels[2] + at, w_blue, blue);
        });
    }
    for_columns(weights, line,
                [&](std::size_t at, const std::int32_t* offsets, std::int32_t across, const float* shares) HWY_ATTR {
                    const FourTexels of_columns = load_texels(samples, at);
                    for (std::size_t i = 0; i < 4; ++i) {
                        const auto share = hn::Set(four, shares[i]), sample = of_columns[i];
                        auto high = hn::Mul(share, sample), low = hn::Sub(sample, high);
                        if constexpr (squares) {
                            const auto rest = hn::Sub(hn::Set(four, 1.0f), share);
                            high = hn::Mul(share, high), low = hn::Mul(hn::Mul(rest, rest), sample);
                        }
                        float* const texel = map + offsets[i];
                        hn::StoreU(hn::Add(low, hn::LoadU(four, texel)), four, texel);
                        hn::StoreU(hn::Add(high, hn::LoadU(four, texel + across)), four, texel + across);
                    }
                });
}

void read_of(const Weights& weights, const MapLine& line, std::span<const LineReader> readers, const vec4* texels,
             vec4* of_reader) {
    weights.is_coloured ? read_with<true>(weights, line, readers, &texels->x, of_reader)
                        : read_with<false>(weights, line, readers, &texels->x, of_reader);
}
void add_of(const Weights& weights, const MapLine& line, std::span<const LineReader> readers, const vec4* ray_values,
            bool squares, vec4* texels) {
    float* const map = &texels->x;
    if (weights.is_coloured)
        squares ? add_with<true, true>(weights, line, readers, ray_values, map)
                : add_with<true, false>(weights, line, readers, ray_values, map);
    else
        squares ? add_with<false, true>(weights, line, readers, ray_values, map)
                : add_with<false, false>(weights, line, readers, ray_values, map);
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
