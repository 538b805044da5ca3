// SPDX-License-Identifier: GPL-3.0-or-later
#include "volume/air_noise_kernel.hpp"
#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volume/air_noise_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tyndall::air_noise::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<float, 16>;
static constexpr Tag d;
static constexpr hn::RebindToSigned<Tag> di;
static constexpr hn::Repartition<std::int64_t, Tag> d_index;
static constexpr hn::Repartition<std::uint64_t, Tag> d_cell;
static constexpr hn::Repartition<std::int16_t, Tag> d_short;
static constexpr hn::Repartition<std::uint8_t, Tag> d_byte;
static constexpr std::size_t lanes_count = hn::MaxLanes(d);
using V = hn::Vec<Tag>;
using I = hn::Vec<decltype(di)>;

/// Steps that carry weight, side by side.
struct Lit {
    static constexpr std::size_t capacity = 256; ///< Then they are summed, and the next ones follow.
    alignas(64) float at_m[capacity + 16], weights[capacity + 16], sequence[capacity + 16];
    alignas(64) std::int32_t level[capacity + 16];
    std::size_t count = 0;
};

/// Per step, what its level says.
struct StepLevels {
    I side_bits, first;
    V scale;
};
static HWY_INLINE StepLevels levels_at(const NoiseRay& ray, const float* sequence, const std::int32_t* level) {
    if (ray.level_of_step != nullptr) {
        static_assert(sizeof(PackedLevel) == 12);
        const I at = hn::Mul(hn::Load(di, level), hn::Set(di, 3));
        const auto* const table = reinterpret_cast<const std::int32_t*>(ray.all_levels);
        return {hn::GatherIndex(di, table + 1, at), hn::GatherIndex(di, table, at),
                hn::BitCast(d, hn::GatherIndex(di, table + 2, at))};
    }
    const auto is_second = hn::Ge(hn::Add(hn::Load(d, sequence), hn::Set(d, ray.second_share)), hn::Set(d, 1.0f));
    const auto is_second_whole = hn::RebindMask(di, is_second);
    const auto& [a, b] = ray.levels;
    const auto choose = [&](std::uint32_t of_first, std::uint32_t of_second) {
        return hn::IfThenElse(is_second_whole, hn::Set(di, static_cast<std::int32_t>(of_second)),
                              hn::Set(di, static_cast<std::int32_t>(of_first)));
    };
    return {choose(a.side_bits, b.side_bits), choose(a.first, b.first),
            hn::IfThenElse(is_second, hn::Set(d, b.scale), hn::Set(d, a.scale))};
}

/// A cell along one axis, and how far into it, in 128ths.
struct Along {
    I cell, share;
};
static HWY_INLINE Along along(const NoiseRay& ray, std::size_t axis, V at_m, I side_bits) {
    const V place = hn::MulAdd(at_m, hn::Set(d, ray.direction[axis]), hn::Set(d, ray.origin[axis]));
    const V within = hn::Sub(place, hn::Floor(place));
    // 24 bits of a cube's length; texels begin half a texel before their middle.
    I whole = hn::ConvertTo(di, hn::Mul(within, hn::Set(d, 16777216.0f)));
    whole = hn::Sub(whole, hn::Shr(hn::Set(di, 1 << 23), side_bits));
    whole = hn::And(whole, hn::Set(di, 0xffffff));
    const I rest_bits = hn::Sub(hn::Set(di, 24), side_bits);
    return {hn::Shr(whole, rest_bits), hn::And(hn::Shr(whole, hn::Sub(rest_bits, hn::Set(di, 7))), hn::Set(di, 127))};
}

/// Sum over z of the weighted values of half a vector's steps: two lanes per step.
static HWY_INLINE V summed_cells(const NoiseRay& ray, hn::Vec<decltype(d_index)> index,
                                 hn::Vec<decltype(d_cell)> shares, V weights_of_z) {
    // Into the 4 pairs of bytes of a step: its share along x; along y and 128 less it.
    alignas(16) static constexpr std::uint8_t of_x[16] = {0, 255, 0, 255, 0, 255, 0, 255,
                                                          8, 255, 8, 255, 8, 255, 8, 255};
    alignas(16) static constexpr std::uint8_t of_y[16] = {2,  255, 1, 255, 2,  255, 1, 255,
                                                          10, 255, 9, 255, 10, 255, 9, 255};
    const auto corners = hn::GatherIndex(d_cell, ray.corners, index);
    const auto shorts = hn::BitCast(d_short, corners);
    const auto before = hn::And(shorts, hn::Set(d_short, 255));
    const auto after =
        hn::BitCast(d_short, hn::ShiftRight<8>(hn::BitCast(hn::RebindToUnsigned<decltype(d_short)>(), corners)));
    const auto bytes = hn::BitCast(d_byte, shares);
    const auto share_x = hn::BitCast(d_short, hn::TableLookupBytesOr0(bytes, hn::LoadDup128(d_byte, of_x)));
    const auto share_y = hn::BitCast(d_short, hn::TableLookupBytesOr0(bytes, hn::LoadDup128(d_byte, of_y)));
    // At most 255 * 128: below 2^15.
    const auto rows = hn::Add(hn::ShiftLeft<7>(before), hn::Mul(hn::Sub(after, before), share_x));
    auto unused = hn::Zero(di);
    const I layers = hn::ReorderWidenMulAccumulate(di, rows, share_y, hn::Zero(di), unused); // pairs, on x86
    return hn::Mul(hn::ConvertTo(d, layers), weights_of_z);
}

/// weight * N / mean(N) * 128^2 of a vector of steps, two lanes per step: those of the first and of the second half of
/// each 128 bits.
struct NoiseHalves {
    V lower, upper;
};
static HWY_INLINE NoiseHalves noise_at(const NoiseRay& ray, V at_m, const StepLevels& level, V weights) {
    const Along x = along(ray, 0, at_m, level.side_bits), y = along(ray, 1, at_m, level.side_bits),
                z = along(ray, 2, at_m, level.side_bits);
    const I row = hn::Or(hn::Shl(z.cell, level.side_bits), y.cell);
    const I index = hn::Add(hn::Or(hn::Shl(row, level.side_bits), x.cell), level.first);
    const I shares =
        hn::Or(hn::Or(x.share, hn::ShiftLeft<8>(y.share)), hn::ShiftLeft<16>(hn::Sub(hn::Set(di, 128), y.share)));
    const V weight = hn::Mul(weights, level.scale);
    const V of_upper = hn::Mul(weight, hn::Mul(hn::ConvertTo(d, z.share), hn::Set(d, 1.0f / 128)));
    const V of_lower = hn::Sub(weight, of_upper);
    const I none = hn::Zero(di);
    return {summed_cells(ray, hn::BitCast(d_index, hn::InterleaveLower(di, index, none)),
                         hn::BitCast(d_cell, hn::InterleaveLower(di, shares, none)),
                         hn::InterleaveLower(d, of_lower, of_upper)),
            summed_cells(ray, hn::BitCast(d_index, hn::InterleaveUpper(di, index, none)),
                         hn::BitCast(d_cell, hn::InterleaveUpper(di, shares, none)),
                         hn::InterleaveUpper(d, of_lower, of_upper))};
}

static HWY_INLINE float sum_of(const NoiseRay& ray, Lit& lit) {
    for (std::size_t i = lit.count; i < lit.count + hn::Lanes(d); ++i)
        lit.at_m[i] = lit.weights[i] = lit.sequence[i] = 0.0f, lit.level[i] = 0;
    V sum = hn::Zero(d);
    for (std::size_t i = 0; i < lit.count; i += hn::Lanes(d)) {
        const auto [lower, upper] =
            noise_at(ray, hn::Load(d, lit.at_m + i), levels_at(ray, lit.sequence + i, lit.level + i),
                     hn::Load(d, lit.weights + i));
        sum = hn::Add(hn::Add(sum, lower), upper);
    }
    lit.count = 0;
    return hn::GetLane(hn::SumOfLanes(d, sum));
}

void find_of_ray(const NoiseRay& ray, float* values) {
    alignas(64) float at_m[lanes_count] = {}, sequence[lanes_count] = {}, found[lanes_count];
    alignas(64) std::int32_t level[lanes_count] = {};
    for (std::size_t i = 0; i < ray.count; i += lanes_count) {
        const std::size_t count = std::min(lanes_count, ray.count - i);
        std::copy_n(ray.at_m + i, count, at_m);
        if (ray.level_of_step != nullptr)
            std::copy_n(ray.level_of_step + i, count, level);
        else
            std::copy_n(ray.sequence + i, count, sequence);
        const auto [lower, upper] =
            noise_at(ray, hn::Load(d, at_m), levels_at(ray, sequence, level), hn::Set(d, 1.0f / (128 * 128)));
        const V of_lower = hn::Add(lower, hn::Shuffle2301(lower)), of_upper = hn::Add(upper, hn::Shuffle2301(upper));
        const V mixed = hn::OddEven(of_upper, of_lower); // steps 0, 2, 1, 3 of each 128 bits
        hn::Store(hn::InterleaveLower(d, mixed, hn::Shuffle1032(mixed)), d, found);
        std::copy_n(found, count, values + i);
    }
}

NoiseSums sum_of_ray(const NoiseRay& ray) {
    Lit lit;
    float noise = 0.0f;
    V weights = hn::Zero(d);
    const std::size_t whole = ray.count / hn::Lanes(d) * hn::Lanes(d);
    for (std::size_t i = 0; i < whole; i += hn::Lanes(d)) {
        const V weight = hn::LoadU(d, ray.weights + i);
        const auto carries = hn::Ne(weight, hn::Zero(d));
        if (hn::AllFalse(d, carries))
            continue;
        weights = hn::Add(weights, weight);
        hn::CompressStore(hn::LoadU(d, ray.at_m + i), carries, d, lit.at_m + lit.count);
        if (ray.level_of_step != nullptr) {
            const hn::Rebind<std::uint8_t, Tag> d_some;
            hn::CompressStore(hn::PromoteTo(di, hn::LoadU(d_some, ray.level_of_step + i)), hn::RebindMask(di, carries),
                              di, lit.level + lit.count);
        } else {
            hn::CompressStore(hn::LoadU(d, ray.sequence + i), carries, d, lit.sequence + lit.count);
        }
        lit.count += hn::CompressStore(weight, carries, d, lit.weights + lit.count);
        if (lit.count > Lit::capacity - hn::Lanes(d))
            noise += sum_of(ray, lit);
    }
    float weight_sum = hn::GetLane(hn::SumOfLanes(d, weights));
    for (std::size_t i = whole; i < ray.count; ++i) {
        if (ray.weights[i] == 0.0f)
            continue;
        weight_sum += ray.weights[i];
        lit.at_m[lit.count] = ray.at_m[i];
        lit.sequence[lit.count] = ray.level_of_step != nullptr ? 0.0f : ray.sequence[i];
        lit.level[lit.count] = ray.level_of_step != nullptr ? ray.level_of_step[i] : 0;
        lit.weights[lit.count++] = ray.weights[i];
    }
    noise += sum_of(ray, lit);
    return {weight_sum, noise * (1.0f / (128 * 128))};
}
} // namespace tyndall::air_noise::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::air_noise {
HWY_EXPORT(sum_of_ray);
HWY_EXPORT(find_of_ray);
NoiseSums sum_along(const NoiseRay& ray) { return HWY_DYNAMIC_DISPATCH(sum_of_ray)(ray); }
void find_along(const NoiseRay& ray, float* values) { HWY_DYNAMIC_DISPATCH(find_of_ray)(ray, values); }
} // namespace tyndall::air_noise
#endif
