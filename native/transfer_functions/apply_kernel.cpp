// SPDX-License-Identifier: GPL-3.0-or-later
// Sums are never fused with products: each instruction set gives the same bits.
#include "transfer_functions/apply_kernel.hpp"
#include <algorithm>
#include <array>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "transfer_functions/apply_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tyndall::transfer_functions::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<float, 16>;
using V = hn::Vec<Tag>;
static constexpr Tag d;
static constexpr hn::RebindToSigned<Tag> di;
using TexelTag = hn::FixedTag<float, 4>;
static constexpr TexelTag d_texel;
using I = hn::Vec<decltype(di)>;
/// Rays at a time: each of three steps goes over all of them, and finds what the one before has stored in the first cache.
static constexpr std::size_t together = 64;
template <typename Item>
using Some = std::array<Item, together>;

/// Between which two texels a parameter lies along one axis; the upper is always the next.
struct Along {
    I lower;
    V share; ///< Of the upper.
};
static HWY_INLINE Along along(V parameter, float size) {
    const V position = hn::Sub(hn::Mul(parameter, hn::Set(d, size)), hn::Set(d, 0.5f));
    // False for what is no number: it reads the first texel.
    const V inside = hn::IfThenElseZero(hn::Gt(position, hn::Zero(d)), hn::Min(position, hn::Set(d, size - 1.0f)));
    const I lower = hn::ConvertTo(di, hn::Min(inside, hn::Set(d, size - 2.0f)));
    return {lower, hn::Sub(inside, hn::ConvertTo(d, lower))};
}

/// Equal ends give themselves, whatever the share is.
template <typename D>
static HWY_INLINE hn::Vec<D> between(D, hn::Vec<D> a, hn::Vec<D> b, hn::Vec<D> share) {
    return hn::Add(a, hn::Mul(share, hn::Sub(b, a)));
}

/// Between four texels: the first of them, and where the row above begins. No gather is faster than these loads.
static HWY_INLINE hn::Vec<TexelTag> colour_at(const float* first, std::size_t row, float share_x, float share_y) {
#if HWY_MAX_BYTES >= 32
    const hn::FixedTag<float, 8> d_two;
    const auto two = between(d_two, hn::LoadU(d_two, first), hn::LoadU(d_two, first + row), hn::Set(d_two, share_y));
    const auto left = hn::LowerHalf(d_texel, two), right = hn::UpperHalf(d_texel, two);
#else
    const auto column = [&](const float* texel) {
        return between(d_texel, hn::LoadU(d_texel, texel), hn::LoadU(d_texel, texel + row), hn::Set(d_texel, share_y));
    };
    const auto left = column(first), right = column(first + 4);
#endif
    return between(d_texel, left, right, hn::Set(d_texel, share_x));
}

/// Where rays read the function.
struct Places {
    alignas(64) Some<std::int32_t> first; ///< Number of the texels' numbers, 4 per texel.
    alignas(64) Some<float> share_x, share_y;
};
static HWY_INLINE void find(const ComposedFunction& function, const vec2* parameters, Places& places) {
    const auto size = static_cast<float>(function.size);
    for (std::size_t i = 0; i < together; i += hn::Lanes(d)) {
        V x, y;
        hn::LoadInterleaved2(d, &parameters[i].x, x, y);
        const Along column = along(x, size), row = along(y, size);
        const I of_row = hn::Mul(row.lower, hn::Set(di, static_cast<std::int32_t>(function.size)));
        hn::Store(hn::ShiftLeft<2>(hn::Add(of_row, column.lower)), di, &places.first[i]);
        hn::Store(column.share, d, &places.share_x[i]);
        hn::Store(row.share, d, &places.share_y[i]);
    }
}

/// What the function's colour is multiplied with, per ray.
template <Use use>
static HWY_INLINE void find_scale(const Application& application, const Rgb* radiance, const float* share,
                                  Some<float>& scale) {
    for (std::size_t i = 0; i < together; i += hn::Lanes(d)) {
        V of_ray = hn::Set(d, application.strength);
        if constexpr (use == Use::Tint) {
            V r, g, b;
            hn::LoadInterleaved3(d, &radiance[i].x, r, g, b);
            of_ray = hn::Add(hn::Add(hn::Mul(r, hn::Set(d, 0.2126f)), hn::Mul(g, hn::Set(d, 0.7152f))),
                             hn::Mul(b, hn::Set(d, 0.0722f))); // luminance, Rec. 709
        } else if (share != nullptr) {
            of_ray = hn::Mul(of_ray, hn::LoadU(d, share + i));
        }
        hn::Store(of_ray, d, &scale[i]);
    }
}

template <Use use>
static HWY_INLINE void change_some(const ComposedFunction& function, const Application& application,
                                   const vec2* parameters, const Rgb* radiance, const float* share, Rgb* change) {
    Places places;
    find(function, parameters, places);
    alignas(64) Some<float> scale;
    if constexpr (use != Use::Multiply)
        find_scale<use>(application, radiance, share, scale);

    // Three numbers per ray, as radiance and change are; each ray's fourth makes way for the next ray's first.
    alignas(64) std::array<float, 3 * together + 1> colour, alpha;
    const float* texels = &function.texels[0].x;
    for (std::size_t ray = 0; ray < together; ++ray) {
        const auto found = colour_at(texels + static_cast<std::uint32_t>(places.first[ray]),
                                     std::size_t{4} * function.size, places.share_x[ray], places.share_y[ray]);
        const auto its_alpha = hn::Broadcast<3>(found);
        if constexpr (use == Use::Multiply) {
            // White is equal to its alpha: the difference of the two is 0, where that of their products might not be.
            hn::StoreU(hn::Sub(found, its_alpha), d_texel, &colour[3 * ray]);
        } else {
            hn::StoreU(hn::Mul(found, hn::Set(d_texel, scale[ray])), d_texel, &colour[3 * ray]);
            hn::StoreU(its_alpha, d_texel, &alpha[3 * ray]);
        }
    }

    const V weight = hn::Set(d, application.weight);
    for (std::size_t i = 0; i < 3 * together; i += hn::Lanes(d)) {
        const V of_ray = hn::LoadU(d, &radiance->x + i), of_function = hn::Load(d, &colour[i]);
        V difference;
        if constexpr (use == Use::Multiply)
            difference = hn::Mul(of_ray, of_function);
        else
            difference = hn::Sub(of_function, hn::Mul(hn::Load(d, &alpha[i]), of_ray));
        hn::StoreU(hn::Add(hn::LoadU(d, &change->x + i), hn::Mul(weight, difference)), d, &change->x + i);
    }
}

template <Use use>
static void change_all(const ComposedFunction& function, const Application& application, const RayStretch& rays) {
    const std::size_t whole = rays.count / together * together, rest = rays.count - whole;
    for (std::size_t i = 0; i < whole; i += together)
        change_some<use>(function, application, rays.parameters + i, rays.radiance + i,
                         rays.share == nullptr ? nullptr : rays.share + i, rays.change + i);
    if (rest == 0)
        return;
    Some<vec2> parameters{};
    Some<Rgb> radiance{}, change{};
    Some<float> share{};
    std::copy_n(rays.parameters + whole, rest, parameters.begin());
    std::copy_n(rays.radiance + whole, rest, radiance.begin());
    std::copy_n(rays.change + whole, rest, change.begin());
    if (rays.share != nullptr)
        std::copy_n(rays.share + whole, rest, share.begin());
    change_some<use>(function, application, parameters.data(), radiance.data(),
                     rays.share == nullptr ? nullptr : share.data(), change.data());
    std::copy_n(change.begin(), rest, rays.change + whole);
}

void apply_of(const ComposedFunction& function, const Application& application, const RayStretch& rays) {
    switch (application.use) {
    case Use::Replace:
        return change_all<Use::Replace>(function, application, rays);
    case Use::Multiply:
        return change_all<Use::Multiply>(function, application, rays);
    case Use::Tint:
        return change_all<Use::Tint>(function, application, rays);
    }
}
} // namespace tyndall::transfer_functions::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::transfer_functions {
HWY_EXPORT(apply_of);

void apply_to(const ComposedFunction& function, const Application& application, const RayStretch& rays) {
    HWY_DYNAMIC_DISPATCH(apply_of)(function, application, rays);
}
} // namespace tyndall::transfer_functions
#endif
