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
static constexpr hn::FixedTag<float, 4> d_texel;
using I = hn::Vec<decltype(di)>;
static constexpr std::size_t most_lanes = 16;

/// Numbers of a vector of rays, as memory has them.
struct Lanes {
    alignas(64) std::array<vec2, most_lanes> parameters;
    alignas(64) std::array<Rgb, most_lanes> radiance, change;
    alignas(64) std::array<float, most_lanes> share;
};

/// Between which texels a parameter lies along one axis.
struct Along {
    I lower, upper;
    V share; ///< Of the upper.
};
static HWY_INLINE Along along(V parameter, float size) {
    const V position = hn::Sub(hn::Mul(parameter, hn::Set(d, size)), hn::Set(d, 0.5f));
    const V last = hn::Set(d, size - 1.0f);
    // False for what is no number: it reads the first texel.
    const V inside = hn::Min(hn::IfThenElseZero(hn::Gt(position, hn::Zero(d)), position), last);
    const I lower = hn::ConvertTo(di, inside);
    return {lower, hn::Min(hn::Add(lower, hn::Set(di, 1)), hn::ConvertTo(di, last)),
            hn::Sub(inside, hn::ConvertTo(d, lower))};
}

/// Equal ends give themselves, whatever the share is.
template <typename D>
static HWY_INLINE hn::Vec<D> between(hn::Vec<D> a, hn::Vec<D> b, hn::Vec<D> share) {
    return hn::Add(a, hn::Mul(share, hn::Sub(b, a)));
}

/// Red, green, blue and alpha of a vector of rays.
static HWY_INLINE void look_up(const ComposedFunction& function, const vec2* parameters, V& r, V& g, V& b, V& alpha) {
    V x, y;
    hn::LoadInterleaved2(d, &parameters->x, x, y);
    const Along column = along(x, static_cast<float>(function.size)), row = along(y, static_cast<float>(function.size));
    alignas(64) std::array<std::int32_t, most_lanes> first[2][2];
    alignas(64) std::array<float, most_lanes> share_x, share_y;
    const I size = hn::Set(di, static_cast<std::int32_t>(function.size));
    const I rows[2] = {hn::Mul(row.lower, size), hn::Mul(row.upper, size)};
    for (std::size_t j = 0; j < 2; ++j) {
        hn::Store(hn::Add(rows[j], column.lower), di, first[j][0].data());
        hn::Store(hn::Add(rows[j], column.upper), di, first[j][1].data());
    }
    hn::Store(column.share, d, share_x.data());
    hn::Store(row.share, d, share_y.data());

    alignas(64) std::array<vec4, most_lanes> colours;
    for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) { // a texel is a vector of four: no gather is faster
        const auto texel = [&](std::size_t j, std::size_t i) {
            return hn::LoadU(d_texel, &function.texels[static_cast<std::size_t>(first[j][i][lane])].x);
        };
        const auto in_row = [&](std::size_t j) {
            return between<decltype(d_texel)>(texel(j, 0), texel(j, 1), hn::Set(d_texel, share_x[lane]));
        };
        hn::Store(between<decltype(d_texel)>(in_row(0), in_row(1), hn::Set(d_texel, share_y[lane])), d_texel,
                  &colours[lane].x);
    }
    hn::LoadInterleaved4(d, &colours[0].x, r, g, b, alpha);
}

template <Use use>
static HWY_INLINE void change_lanes(const ComposedFunction& function, const Application& application,
                                    const vec2* parameters, const Rgb* radiance, const float* share, Rgb* change) {
    V colour[3], alpha, of_ray[3], sum[3];
    look_up(function, parameters, colour[0], colour[1], colour[2], alpha);
    hn::LoadInterleaved3(d, &radiance->x, of_ray[0], of_ray[1], of_ray[2]);
    hn::LoadInterleaved3(d, &change->x, sum[0], sum[1], sum[2]);
    V scale = hn::Set(d, application.strength); // of the colour
    if constexpr (use == Use::Replace) {
        if (share != nullptr)
            scale = hn::Mul(scale, hn::LoadU(d, share));
    } else if constexpr (use == Use::Tint) {
        scale = hn::Add(hn::Add(hn::Mul(of_ray[0], hn::Set(d, 0.2126f)), hn::Mul(of_ray[1], hn::Set(d, 0.7152f))),
                        hn::Mul(of_ray[2], hn::Set(d, 0.0722f))); // luminance, Rec. 709
    }
    const V weight = hn::Set(d, application.weight);
    for (std::size_t c = 0; c < 3; ++c) {
        // White is equal to its alpha: the difference of the two is 0, where that of their products might not be.
        const V by_function = use == Use::Multiply ? hn::Mul(of_ray[c], hn::Sub(colour[c], alpha))
                                                   : hn::Sub(hn::Mul(scale, colour[c]), hn::Mul(alpha, of_ray[c]));
        sum[c] = hn::Add(sum[c], hn::Mul(weight, by_function));
    }
    hn::StoreInterleaved3(sum[0], sum[1], sum[2], d, &change->x);
}

template <Use use>
static void change_all(const ComposedFunction& function, const Application& application, const RayStretch& rays) {
    const std::size_t lanes = hn::Lanes(d), whole = rays.count / lanes * lanes;
    for (std::size_t i = 0; i < whole; i += lanes)
        change_lanes<use>(function, application, rays.parameters + i, rays.radiance + i,
                          rays.share == nullptr ? nullptr : rays.share + i, rays.change + i);
    if (whole == rays.count)
        return;
    const std::size_t rest = rays.count - whole;
    Lanes last{};
    std::copy_n(rays.parameters + whole, rest, last.parameters.begin());
    std::copy_n(rays.radiance + whole, rest, last.radiance.begin());
    std::copy_n(rays.change + whole, rest, last.change.begin());
    if (rays.share != nullptr)
        std::copy_n(rays.share + whole, rest, last.share.begin());
    change_lanes<use>(function, application, last.parameters.data(), last.radiance.data(),
                      rays.share == nullptr ? nullptr : last.share.data(), last.change.data());
    std::copy_n(last.change.begin(), rest, rays.change + whole);
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
