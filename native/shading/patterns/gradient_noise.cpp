// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/patterns/gradient_noise.hpp"
#include <array>
#include <utility>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shading/patterns/gradient_noise.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "shading/patterns/hash_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tyndall::patterns::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Corner i is beyond the cell's low end along axis k where bit k of i is set.
template <int N>
using CornerTag = hn::CappedTag<float, (N < 3 ? 1 << N : 8)>;
alignas(64) static constexpr std::uint32_t corner_indices[16] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};

/// `value`, negative where that bit of `hash` is set.
template <int bit, typename D, typename W, typename V>
static HWY_INLINE V signed_by(D d, W hash, V value) {
    constexpr hn::RebindToUnsigned<D> du;
    const W sign = hn::And(hn::ShiftLeft<31 - bit>(hash), hn::Set(du, 0x80000000u));
    return hn::Xor(value, hn::BitCast(d, sign));
}

/// The gradient that `hash` chooses, times what leads from the corner to the point.
template <int N, typename D, typename W, typename V>
static HWY_INLINE V slope(D d, W hash, const V* from_corner) {
    constexpr hn::RebindToUnsigned<D> du;
    const auto below = [&](W bits, std::uint32_t limit) {
        constexpr hn::RebindToSigned<D> di;
        return hn::RebindMask(d, hn::Lt(hn::BitCast(di, bits), hn::Set(di, static_cast<std::int32_t>(limit))));
    };
    const auto low_bits = [&](std::uint32_t mask) { return hn::And(hash, hn::Set(du, mask)); };
    if constexpr (N == 1) {
        constexpr hn::RebindToSigned<D> di;
        const V steepness = hn::ConvertTo(d, hn::BitCast(di, hn::Add(low_bits(7), hn::Set(du, 1u))));
        return signed_by<3>(d, hash, hn::Mul(steepness, from_corner[0]));
    } else if constexpr (N == 2) {
        const auto is_low = below(low_bits(7), 4);
        const V u = hn::IfThenElse(is_low, from_corner[0], from_corner[1]);
        const V v = hn::IfThenElse(is_low, from_corner[1], from_corner[0]);
        return hn::Add(signed_by<0>(d, hash, u), signed_by<1>(d, hash, hn::Add(v, v)));
    } else if constexpr (N == 3) {
        const W bits = low_bits(15);
        const auto is_x = hn::RebindMask(d, hn::Eq(hn::And(bits, hn::Set(du, 13u)), hn::Set(du, 12u))); // 12 and 14
        const V u = hn::IfThenElse(below(bits, 8), from_corner[0], from_corner[1]);
        const V v =
            hn::IfThenElse(below(bits, 4), from_corner[1], hn::IfThenElse(is_x, from_corner[0], from_corner[2]));
        return hn::Add(signed_by<0>(d, hash, u), signed_by<1>(d, hash, v));
    } else {
        const W bits = low_bits(31);
        const V u = hn::IfThenElse(below(bits, 24), from_corner[0], from_corner[1]);
        const V v = hn::IfThenElse(below(bits, 16), from_corner[1], from_corner[2]);
        const V s = hn::IfThenElse(below(bits, 8), from_corner[2], from_corner[3]);
        return hn::Add(hn::Add(signed_by<0>(d, hash, u), signed_by<1>(d, hash, v)), signed_by<2>(d, hash, s));
    }
}

template <int N>
static HWY_INLINE float value_at(const Point<N>& point) {
    static constexpr float factor_of_dimension[] = {0.25f, 0.6616f, 0.982f, 0.8344f};
    constexpr CornerTag<N> d;
    constexpr hn::RebindToUnsigned<CornerTag<N>> du;
    float low[N], within[N], fade[N];
    for (int axis = 0; axis < N; ++axis) {
        float at = point[axis];
        if (!(std::abs(at) < 100000.0f)) { // also of a NaN
            if (!std::isfinite(at))
                return 0.0f;
            // Between lattice points, where all numbers this large would lie on one.
            const float between = std::abs(at) >= 1000000.0f ? 0.5f : 0.0f;
            at = std::fmod(at, 100000.0f) + between;
        }
        low[axis] = std::floor(at);
        const float t = within[axis] = at - low[axis];
        fade[axis] = t * t * t * (t * (t * 6.0f - 15.0f) + 10.0f);
    }
    auto sum = hn::Zero(d);
    for (std::size_t first = 0; first < (std::size_t{1} << N); first += hn::Lanes(d)) {
        const auto corner = hn::Load(du, corner_indices + first);
        hn::Vec<decltype(du)> cell[N];
        hn::Vec<decltype(d)> from_corner[N], weight = hn::Set(d, 1.0f);
        for (int axis = 0; axis < N; ++axis) {
            const auto is_beyond = hn::Ne(hn::And(corner, hn::Set(du, 1u << axis)), hn::Zero(du));
            const auto low_cell = static_cast<std::uint32_t>(static_cast<std::int32_t>(low[axis]));
            cell[axis] = hn::IfThenElse(is_beyond, hn::Set(du, low_cell + 1), hn::Set(du, low_cell));
            const auto is_far = hn::RebindMask(d, is_beyond);
            from_corner[axis] = hn::IfThenElse(is_far, hn::Set(d, within[axis] - 1.0f), hn::Set(d, within[axis]));
            weight = hn::Mul(weight, hn::IfThenElse(is_far, hn::Set(d, fade[axis]), hn::Set(d, 1.0f - fade[axis])));
        }
        sum = hn::Add(sum, hn::Mul(weight, slope<N>(d, hash_of<N>(du, cell), from_corner)));
    }
    return hn::GetLane(hn::SumOfLanes(d, sum)) * factor_of_dimension[N - 1];
}

template <int N>
static HWY_INLINE void values_at(const Point<N>* points, std::size_t count, float* values) {
    for (std::size_t index = 0; index < count; ++index)
        values[index] = value_at<N>(points[index]);
}
static void values_1(const Point<1>* points, std::size_t count, float* values) { values_at(points, count, values); }
static void values_2(const Point<2>* points, std::size_t count, float* values) { values_at(points, count, values); }
static void values_3(const Point<3>* points, std::size_t count, float* values) { values_at(points, count, values); }
static void values_4(const Point<4>* points, std::size_t count, float* values) { values_at(points, count, values); }
} // namespace tyndall::patterns::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::patterns {
HWY_EXPORT(values_1);
HWY_EXPORT(values_2);
HWY_EXPORT(values_3);
HWY_EXPORT(values_4);
template <>
void gradient_noise<1>(std::span<const Point<1>> points, float* values) {
    HWY_DYNAMIC_DISPATCH(values_1)(points.data(), points.size(), values);
}
template <>
void gradient_noise<2>(std::span<const Point<2>> points, float* values) {
    HWY_DYNAMIC_DISPATCH(values_2)(points.data(), points.size(), values);
}
template <>
void gradient_noise<3>(std::span<const Point<3>> points, float* values) {
    HWY_DYNAMIC_DISPATCH(values_3)(points.data(), points.size(), values);
}
template <>
void gradient_noise<4>(std::span<const Point<4>> points, float* values) {
    HWY_DYNAMIC_DISPATCH(values_4)(points.data(), points.size(), values);
}
} // namespace tyndall::patterns
#endif
