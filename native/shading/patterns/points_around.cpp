// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/patterns/points_around.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "shading/patterns/points_around.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "shading/patterns/hash_lanes-inl.hpp"

// What no target changes: once.
#ifndef TYNDALL_OFFSETS_AROUND
#define TYNDALL_OFFSETS_AROUND
namespace tyndall::patterns {
namespace {
template <int N>
struct Offsets {
    std::size_t count = 1;
    alignas(64) float at[N][most_points_around]{};

    explicit Offsets(int reach) {
        for (int axis = 0; axis < N; ++axis)
            count *= static_cast<std::size_t>(2 * reach + 1);
        for (std::size_t index = 0; index < count; ++index)
            for (int axis = 0; axis < N; ++axis)
                at[axis][index] = offset_of<N>(index, reach)[axis];
    }
};
template <int N>
const Offsets<N>& offsets(int reach) {
    static const Offsets<N> near(1), far(2);
    return reach == 1 ? near : far;
}
} // namespace
} // namespace tyndall::patterns
#endif

HWY_BEFORE_NAMESPACE();
namespace tyndall::patterns::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
static constexpr hn::CappedTag<float, 16> d;
static constexpr hn::RebindToUnsigned<decltype(d)> du;
static constexpr hn::RebindToSigned<decltype(d)> di;
using V = hn::Vec<decltype(d)>;
using W = hn::Vec<decltype(du)>;

/// hash.hpp's random_point(), per lane.
template <int N>
static HWY_INLINE void random_points(const V* cell, V* random) {
    W key[4];
    for (int axis = 0; axis < N; ++axis)
        key[axis] = hn::BitCast(du, cell[axis]);
    const W one = hn::BitCast(du, hn::Set(d, 1.0f)), two = hn::BitCast(du, hn::Set(d, 2.0f));
    random[0] = random_of<N>(d, key);
    if constexpr (N == 2) {
        const W second[] = {key[0], key[1], one};
        random[1] = random_of<3>(d, second);
    } else if constexpr (N == 3) {
        const W second[] = {key[0], key[1], key[2], one}, third[] = {key[0], key[1], key[2], two};
        random[1] = random_of<4>(d, second);
        random[2] = random_of<4>(d, third);
    } else if constexpr (N == 4) {
        const W second[] = {key[3], key[0], key[1], key[2]}, third[] = {key[2], key[3], key[0], key[1]},
                fourth[] = {key[1], key[2], key[3], key[0]};
        random[1] = random_of<4>(d, second);
        random[2] = random_of<4>(d, third);
        random[3] = random_of<4>(d, fourth);
    }
}

/// hash.hpp's permuted_point(), per lane.
template <int N>
static HWY_INLINE void permuted_points(const V* cell, V* random) {
    W v[N];
    const V limit = hn::Set(d, 2147483000.0f);
    for (int axis = 0; axis < N; ++axis) {
        const V bounded = hn::Max(hn::Min(cell[axis], limit), hn::Neg(limit));
        const W whole = hn::BitCast(du, hn::ConvertTo(di, bounded));
        v[axis] = hn::Add(hn::Mul(whole, hn::Set(du, 1664525u)), hn::Set(du, 1013904223u));
    }
    const auto add_product = [&](int target, W a, W b) { v[target] = hn::Add(v[target], hn::Mul(a, b)); };
    const auto stir_all = [&] {
        if constexpr (N == 2) {
            add_product(0, v[1], hn::Set(du, 1664525u));
            add_product(1, v[0], hn::Set(du, 1664525u));
        } else if constexpr (N == 3) {
            add_product(0, v[1], v[2]);
            add_product(1, v[2], v[0]);
            add_product(2, v[0], v[1]);
        } else {
            add_product(0, v[1], v[3]);
            add_product(1, v[2], v[0]);
            add_product(2, v[0], v[1]);
            add_product(3, v[1], v[2]);
        }
    };
    stir_all();
    for (int axis = 0; axis < N; ++axis)
        v[axis] = hn::Xor(v[axis], hn::BitCast(du, hn::ShiftRight<16>(hn::BitCast(di, v[axis]))));
    stir_all();
    for (int axis = 0; axis < N; ++axis) {
        const W positive = hn::And(v[axis], hn::Set(du, 0x7fffffffu));
        random[axis] = hn::Mul(hn::ConvertTo(d, hn::BitCast(di, positive)), hn::Set(d, 1.0f / 2147483647.0f));
    }
}

template <int N>
static HWY_INLINE void find(const Point<N>& cell, const Point<N>& around, const PointsConfig& config,
                            PointsAround<N>& points) {
    const Offsets<N>& all = offsets<N>(config.reach);
    points.count = all.count;
    for (std::size_t first = 0; first < all.count; first += hn::Lanes(d)) {
        V offset[N], at[N], random[N];
        for (int axis = 0; axis < N; ++axis) {
            offset[axis] = hn::Add(hn::Set(d, around[axis]), hn::Load(d, all.at[axis] + first));
            at[axis] = hn::Add(hn::Set(d, cell[axis]), offset[axis]);
        }
        if constexpr (N > 1) {
            if (config.is_permuted)
                permuted_points<N>(at, random);
            else
                random_points<N>(at, random);
        } else {
            random_points<N>(at, random);
        }
        for (int axis = 0; axis < N; ++axis)
            hn::Store(hn::Add(offset[axis], hn::Mul(random[axis], hn::Set(d, config.randomness))), d,
                      points.at[axis] + first);
    }
}
static void find_1(const Point<1>& c, const Point<1>& a, const PointsConfig& k, PointsAround<1>& p) {
    find(c, a, k, p);
}
static void find_2(const Point<2>& c, const Point<2>& a, const PointsConfig& k, PointsAround<2>& p) {
    find(c, a, k, p);
}
static void find_3(const Point<3>& c, const Point<3>& a, const PointsConfig& k, PointsAround<3>& p) {
    find(c, a, k, p);
}
static void find_4(const Point<4>& c, const Point<4>& a, const PointsConfig& k, PointsAround<4>& p) {
    find(c, a, k, p);
}
} // namespace tyndall::patterns::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::patterns {
HWY_EXPORT(find_1);
HWY_EXPORT(find_2);
HWY_EXPORT(find_3);
HWY_EXPORT(find_4);
template <>
void find_points_around(const Point<1>& cell, const Point<1>& around, const PointsConfig& config,
                        PointsAround<1>& points) {
    HWY_DYNAMIC_DISPATCH(find_1)(cell, around, config, points);
}
template <>
void find_points_around(const Point<2>& cell, const Point<2>& around, const PointsConfig& config,
                        PointsAround<2>& points) {
    HWY_DYNAMIC_DISPATCH(find_2)(cell, around, config, points);
}
template <>
void find_points_around(const Point<3>& cell, const Point<3>& around, const PointsConfig& config,
                        PointsAround<3>& points) {
    HWY_DYNAMIC_DISPATCH(find_3)(cell, around, config, points);
}
template <>
void find_points_around(const Point<4>& cell, const Point<4>& around, const PointsConfig& config,
                        PointsAround<4>& points) {
    HWY_DYNAMIC_DISPATCH(find_4)(cell, around, config, points);
}
} // namespace tyndall::patterns
#endif
