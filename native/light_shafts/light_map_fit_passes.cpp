// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/light_map_fit_passes.hpp"
#include <algorithm>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "light_shafts/light_map_fit_passes.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::light_map_passes::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Channel by channel over the lanes of a vector.
struct Add {
    static float of(float a, float b) { return a + b; }
};
struct Least {
    static float of(float a, float b) { return std::min(a, b); }
};
template <class Fold, class D>
static void fold(D d, hn::Vec<D> lanes, vec4& into) {
    alignas(64) float values[16];
    hn::Store(lanes, d, values);
    for (std::size_t i = 0; i < hn::Lanes(d); ++i)
        into[static_cast<int>(i % 4)] = Fold::of(into[static_cast<int>(i % 4)], values[i]);
}
/// Runs work(tag, first float, last float) at full width, and texel by texel for what is left.
template <class Work>
static void at_two_widths(std::size_t begin, std::size_t end, const Work& work) {
    const hn::CappedTag<float, 16> wide;
    const std::size_t whole = begin + (end - begin) / (hn::Lanes(wide) / 4) * (hn::Lanes(wide) / 4);
    work(wide, 4 * begin, 4 * whole);
    work(hn::FixedTag<float, 4>(), 4 * whole, 4 * end);
}

Norms move_of(const Arrays& arrays, const vec4* direction, const vec4& length, std::size_t begin, std::size_t end) {
    Norms norms{vec4(0.0f), vec4(0.0f)};
    float *const texels = &arrays.texels->x, *const gradient = &arrays.gradient->x;
    const float *const way = &direction->x, *const prior = &arrays.prior->x, *const scale = &arrays.scale->x;
    at_two_widths(begin, end, [&](auto d, std::size_t first, std::size_t last) HWY_ATTR {
        const auto zero = hn::Zero(d), lambda = hn::Set(d, arrays.lambda), lengths = hn::LoadDup128(d, &length.x);
        auto free = zero, held = zero;
        for (std::size_t i = first; i < last; i += hn::Lanes(d)) {
            const auto x = hn::Max(hn::MulAdd(lengths, hn::LoadU(d, way + i), hn::LoadU(d, texels + i)), zero);
            const auto s = hn::NegMulAdd(lambda, hn::Sub(x, hn::LoadU(d, prior + i)), hn::LoadU(d, gradient + i));
            hn::StoreU(x, d, texels + i);
            hn::StoreU(s, d, gradient + i);
            const auto square = hn::Mul(hn::Mul(hn::LoadU(d, scale + i), s), s);
            const auto is_free = hn::Gt(x, zero);
            free = hn::Add(free, hn::IfThenElseZero(is_free, square));
            held = hn::Add(held, hn::IfThenElseZero(hn::Gt(s, zero), hn::IfThenZeroElse(is_free, square)));
        }
        fold<Add>(d, free, norms.free);
        fold<Add>(d, held, norms.held);
    });
    return norms;
}

Along turn_of(const Arrays& arrays, const vec4& conjugacy, std::size_t begin, std::size_t end) {
    constexpr float endless = std::numeric_limits<float>::infinity();
    Along along{vec4(0.0f), vec4(0.0f), vec4(0.0f), vec4(endless)};
    float* const direction = &arrays.direction->x;
    const float *const texels = &arrays.texels->x, *const gradient = &arrays.gradient->x,
                       *const priors = &arrays.prior->x, *const scale = &arrays.scale->x;
    at_two_widths(begin, end, [&](auto d, std::size_t first, std::size_t last) HWY_ATTR {
        const auto zero = hn::Zero(d), conjugacies = hn::LoadDup128(d, &conjugacy.x);
        const auto is_fresh = hn::Eq(conjugacies, zero);
        auto of_gradient = zero, square = zero, prior = zero, limit = hn::Set(d, endless);
        for (std::size_t i = first; i < last; i += hn::Lanes(d)) {
            const auto x = hn::LoadU(d, texels + i), s = hn::LoadU(d, gradient + i);
            const auto is_free = hn::Or(hn::Gt(x, zero), hn::And(is_fresh, hn::Gt(s, zero)));
            const auto p = hn::IfThenElseZero(
                is_free, hn::MulAdd(conjugacies, hn::LoadU(d, direction + i), hn::Mul(hn::LoadU(d, scale + i), s)));
            hn::StoreU(p, d, direction + i);
            of_gradient = hn::MulAdd(s, p, of_gradient);
            square = hn::MulAdd(p, p, square);
            prior = hn::MulAdd(p, hn::Sub(x, hn::LoadU(d, priors + i)), prior);
            limit = hn::IfThenElse(hn::Lt(p, zero), hn::Min(limit, hn::Div(x, hn::Neg(p))), limit);
        }
        fold<Add>(d, of_gradient, along.gradient);
        fold<Add>(d, square, along.square);
        fold<Add>(d, prior, along.prior);
        fold<Least>(d, limit, along.limit);
    });
    return along;
}

Along project_of(const Arrays& arrays, const vec4& length, std::size_t begin, std::size_t end) {
    Along along{vec4(0.0f), vec4(0.0f), vec4(0.0f), vec4(1.0f)};
    float* const displacement = &arrays.displacement->x;
    const float *const texels = &arrays.texels->x, *const gradient = &arrays.gradient->x,
                       *const direction = &arrays.direction->x, *const priors = &arrays.prior->x;
    at_two_widths(begin, end, [&](auto d, std::size_t first, std::size_t last) HWY_ATTR {
        const auto lengths = hn::LoadDup128(d, &length.x);
        auto of_gradient = hn::Zero(d), square = of_gradient, prior = of_gradient;
        for (std::size_t i = first; i < last; i += hn::Lanes(d)) {
            const auto x = hn::LoadU(d, texels + i);
            const auto moved = hn::Max(hn::Mul(lengths, hn::LoadU(d, direction + i)), hn::Neg(x));
            hn::StoreU(moved, d, displacement + i);
            of_gradient = hn::MulAdd(hn::LoadU(d, gradient + i), moved, of_gradient);
            square = hn::MulAdd(moved, moved, square);
            prior = hn::MulAdd(moved, hn::Sub(x, hn::LoadU(d, priors + i)), prior);
        }
        fold<Add>(d, of_gradient, along.gradient);
        fold<Add>(d, square, along.square);
        fold<Add>(d, prior, along.prior);
    });
    return along;
}
} // namespace tyndall::light_shafts::light_map_passes::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::light_shafts::light_map_passes {
HWY_EXPORT(move_of);
HWY_EXPORT(turn_of);
HWY_EXPORT(project_of);

Norms move(const Arrays& arrays, const vec4* direction, const vec4& length, std::size_t begin, std::size_t end) {
    return HWY_DYNAMIC_DISPATCH(move_of)(arrays, direction, length, begin, end);
}
Along turn(const Arrays& arrays, const vec4& conjugacy, std::size_t begin, std::size_t end) {
    return HWY_DYNAMIC_DISPATCH(turn_of)(arrays, conjugacy, begin, end);
}
Along project(const Arrays& arrays, const vec4& length, std::size_t begin, std::size_t end) {
    return HWY_DYNAMIC_DISPATCH(project_of)(arrays, length, begin, end);
}
} // namespace tyndall::light_shafts::light_map_passes
#endif
