// SPDX-License-Identifier: GPL-3.0-or-later
#include "volume/painted_kernel.hpp"
#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volume/painted_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tyndall::painted::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<float, 16>;
static constexpr Tag d;
static constexpr hn::RebindToSigned<Tag> di;
using V = hn::Vec<Tag>;
using I = hn::Vec<decltype(di)>;

/// The samples before and after a point along one axis, and the share of the latter.
struct Between {
    I before, after;
    V share;
};
static HWY_INLINE Between between(const VolumeRay& ray, std::size_t axis, V at_m) {
    const auto last = static_cast<std::int32_t>(ray.size[axis]) - 1;
    const V place = hn::MulAdd(at_m, hn::Set(d, ray.direction[axis]), hn::Set(d, ray.origin[axis]));
    const V inside = hn::Min(hn::Max(place, hn::Zero(d)), hn::Set(d, static_cast<float>(last)));
    const I before = hn::ConvertTo(di, inside);
    return {before, hn::Min(hn::Add(before, hn::Set(di, 1)), hn::Set(di, last)),
            hn::Sub(inside, hn::ConvertTo(d, before))};
}
static HWY_INLINE V mix(V a, V b, V share) { return hn::MulAdd(share, hn::Sub(b, a), a); }

static HWY_INLINE V sampled(const VolumeRay& ray, V at_m) {
    const I per_row = hn::Set(di, static_cast<std::int32_t>(ray.size[0])),
            per_layer = hn::Set(di, static_cast<std::int32_t>(ray.size[0] * ray.size[1]));
    const Between x = between(ray, 0, at_m), y = between(ray, 1, at_m), z = between(ray, 2, at_m);
    const auto row = [&](I layer, I line) HWY_ATTR {
        const I first = hn::Add(hn::Mul(layer, per_layer), hn::Mul(line, per_row));
        return mix(hn::GatherIndex(d, ray.values, hn::Add(first, x.before)),
                   hn::GatherIndex(d, ray.values, hn::Add(first, x.after)), x.share);
    };
    const auto layer = [&](I index) HWY_ATTR { return mix(row(index, y.before), row(index, y.after), y.share); };
    return mix(layer(z.before), layer(z.after), z.share);
}

void sample_along_of(const VolumeRay& ray, const float* at_m, const float* weights, std::size_t count, float* values) {
    constexpr std::size_t most_lanes = hn::MaxLanes(d);
    std::size_t at = 0;
    for (; at + hn::Lanes(d) <= count; at += hn::Lanes(d))
        if (!hn::AllTrue(d, hn::Eq(hn::LoadU(d, weights + at), hn::Zero(d))))
            hn::StoreU(sampled(ray, hn::LoadU(d, at_m + at)), d, values + at);
    if (at == count)
        return;
    alignas(64) float rest[most_lanes] = {};
    std::copy_n(at_m + at, count - at, rest);
    hn::Store(sampled(ray, hn::Load(d, rest)), d, rest);
    std::copy_n(rest, count - at, values + at);
}
} // namespace tyndall::painted::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::painted {
HWY_EXPORT(sample_along_of);

void sample_along(const VolumeRay& ray, const float* at_m, const float* weights, std::size_t count, float* values) {
    HWY_DYNAMIC_DISPATCH(sample_along_of)(ray, at_m, weights, count, values);
}
} // namespace tyndall::painted
#endif
