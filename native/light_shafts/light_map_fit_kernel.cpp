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
/// Lines of texels side by side. Not 16: what is stored as 64 bytes and read again 4 at a time waits for the cache.
using Lines = hn::CappedTag<float, 8>;
using Colour = hn::FixedTag<float, 4>;
static constexpr Lines lines;
static constexpr Colour colour;

/// Calls visit.first or visit.second(offset, across, low, high) for each line of a stretch: the first of its two texels and
/// the way to the other, in floats, and the weights of both, as vectors over the channels. Two by turns, so that sums need
/// not wait for each other.
template <bool is_coloured, typename Visit>
static HWY_INLINE void for_lines(const Weights& weights, const RowStretch& stretch, Visit& visit) {
    const hn::RebindToSigned<Lines> offsets;
    const std::size_t lane_count = hn::Lanes(lines), line_count = stretch.count;
    const auto resolution = static_cast<std::int32_t>(weights.resolution),
               row = 4 * static_cast<std::int32_t>(weights.pitch);
    const std::int32_t per_line = stretch.goes_along_y ? row : 4, across = row + 4 - per_line;
    const float* weight = weights.first + std::size_t{stretch.first_weight} * (is_coloured ? 4 : 1);
    alignas(32) std::int32_t offset[8];
    alignas(32) float low[8], high[8];
    const auto last = hn::Set(offsets, resolution - 2), across_in_floats = hn::Set(offsets, across);
    const auto lane = hn::Iota(lines, 0.0f);
    auto line_offset = hn::Mul(hn::Add(hn::Iota(offsets, 0), hn::Set(offsets, std::int32_t{stretch.first_line})),
                               hn::Set(offsets, per_line));
    const auto offset_step = hn::Set(offsets, static_cast<std::int32_t>(lane_count) * per_line);
    for (std::size_t begin = 0; begin < line_count; begin += lane_count) {
        const auto position =
            hn::MulAdd(hn::Add(lane, hn::Set(lines, static_cast<float>(begin))),
                       hn::Set(lines, stretch.across_per_line), hn::Set(lines, stretch.across_at_first));
        const auto first = hn::Min(hn::Max(hn::ConvertTo(offsets, position), hn::Zero(offsets)), last);
        const auto share =
            hn::Clamp(hn::Sub(position, hn::ConvertTo(lines, first)), hn::Zero(lines), hn::Set(lines, 1.0f));
        hn::Store(hn::Add(line_offset, hn::Mul(first, across_in_floats)), offsets, offset);
        line_offset = hn::Add(line_offset, offset_step);
        const std::size_t count = std::min(lane_count, line_count - begin);
        if constexpr (is_coloured) {
            hn::Store(share, lines, high);
            for (std::size_t i = 0; i < count; ++i) {
                const auto w = hn::LoadU(colour, weight + 4 * (begin + i));
                const auto of_second = hn::Mul(w, hn::Set(colour, high[i]));
                visit.first(offset[i], across, hn::Sub(w, of_second), of_second);
            }
        } else {
            const auto w = hn::LoadU(lines, weight + begin); // the weights have slack behind the last one
            const auto of_second = hn::Mul(w, share);
            hn::Store(hn::Sub(w, of_second), lines, low);
            hn::Store(of_second, lines, high);
            // Unrolled, the compiler would take the vectors apart in registers, at three times the operations.
#pragma GCC unroll 1
            for (std::size_t i = 0; i + 1 < count; i += 2) {
                visit.first(offset[i], across, hn::Set(colour, low[i]), hn::Set(colour, high[i]));
                visit.second(offset[i + 1], across, hn::Set(colour, low[i + 1]), hn::Set(colour, high[i + 1]));
            }
            if (count % 2 == 1)
                visit.first(offset[count - 1], across, hn::Set(colour, low[count - 1]),
                            hn::Set(colour, high[count - 1]));
        }
    }
}

using Channels = hn::Vec<Colour>;
struct Reader {
    const float* map;
    Channels low = hn::Zero(colour), high = low, other_low = low, other_high = low;
    HWY_INLINE void first(std::int32_t offset, std::int32_t across, Channels weight, Channels of_second) {
        low = hn::MulAdd(weight, hn::LoadU(colour, map + offset), low);
        high = hn::MulAdd(of_second, hn::LoadU(colour, map + offset + across), high);
    }
    HWY_INLINE void second(std::int32_t offset, std::int32_t across, Channels weight, Channels of_second) {
        other_low = hn::MulAdd(weight, hn::LoadU(colour, map + offset), other_low);
        other_high = hn::MulAdd(of_second, hn::LoadU(colour, map + offset + across), other_high);
    }
};
template <bool squares>
struct Adder {
    float* map;
    Channels value;
    HWY_INLINE void first(std::int32_t offset, std::int32_t across, Channels low, Channels high) const {
        if constexpr (squares) {
            low = hn::Mul(low, low);
            high = hn::Mul(high, high);
        }
        float* const texel = map + offset;
        hn::StoreU(hn::MulAdd(low, value, hn::LoadU(colour, texel)), colour, texel);
        hn::StoreU(hn::MulAdd(high, value, hn::LoadU(colour, texel + across)), colour, texel + across);
    }
    HWY_INLINE void second(std::int32_t offset, std::int32_t across, Channels low, Channels high) const {
        first(offset, across, low, high);
    }
};

vec4 read_of(const Weights& weights, const RowStretch& stretch, const vec4* texels) {
    Reader reader{&texels->x};
    weights.is_coloured ? for_lines<true>(weights, stretch, reader) : for_lines<false>(weights, stretch, reader);
    vec4 result;
    hn::StoreU(hn::Add(hn::Add(reader.low, reader.high), hn::Add(reader.other_low, reader.other_high)), colour,
               &result.x);
    return result;
}
void add_of(const Weights& weights, const RowStretch& stretch, const vec4& value, bool squares, vec4* texels) {
    const Channels channels = hn::LoadU(colour, &value.x);
    const Adder<false> adder{&texels->x, channels};
    const Adder<true> of_squares{&texels->x, channels};
    if (weights.is_coloured)
        squares ? for_lines<true>(weights, stretch, of_squares) : for_lines<true>(weights, stretch, adder);
    else
        squares ? for_lines<false>(weights, stretch, of_squares) : for_lines<false>(weights, stretch, adder);
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

vec4 read(const Weights& weights, const RowStretch& stretch, const vec4* texels) {
    return HWY_DYNAMIC_DISPATCH(read_of)(weights, stretch, texels);
}
void add(const Weights& weights, const RowStretch& stretch, const vec4& value, bool squares, vec4* texels) {
    HWY_DYNAMIC_DISPATCH(add_of)(weights, stretch, value, squares, texels);
}
void attenuate(std::span<const float> depth, std::span<float> amount) {
    HWY_DYNAMIC_DISPATCH(attenuate_of)(depth, amount);
}
} // namespace tyndall::light_shafts::light_map_kernel
#endif
