// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/shared_strata_kernel.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "light_shafts/shared_strata_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
namespace shared_strata_lanes {
namespace hn = hwy::HWY_NAMESPACE;
using namespace shared_strata;
static constexpr hn::CappedTag<float, line_padding> d;
static constexpr std::size_t lanes = hn::MaxLanes(d);
using V = hn::Vec<decltype(d)>;

static HWY_INLINE auto are_alike(V a, V b) {
    const V apart = hn::Abs(hn::Sub(a, b)); // of two infinities a NaN
    return hn::Or(hn::Eq(a, b), hn::Le(apart, hn::Mul(hn::Set(d, alike_tolerance), hn::Min(a, b))));
}

template <bool has_patterned>
static void add_line(const LinesAround& around, float* light, float* visible) {
    const V zero = hn::Zero(d);
    const float* const middle = around.lines[static_cast<std::size_t>(around.reach)];
    for (std::size_t x = 0; x < around.width; x += lanes) {
        const auto here = [&](Column column) { return hn::LoadU(d, middle + column * around.stride + x); };
        const V own_near = here(near_m), own_far = here(far_m), own_opacity = here(opacity);
        V sum[3] = {zero, zero, zero}, shared[3] = {zero, zero, zero}, whole[3] = {zero, zero, zero},
          kept[3] = {zero, zero, zero};
        V visibility_sum = zero, weight_sum = zero, weight_here = zero, opacity_sum = zero;
        for (std::int32_t dy = -around.reach; dy <= around.reach; ++dy) {
            const float* const line = around.lines[static_cast<std::size_t>(dy + around.reach)];
            if (line == nullptr)
                continue;
            for (std::int32_t dx = -around.reach; dx <= around.reach; ++dx) {
                const float* const beside = line + static_cast<std::ptrdiff_t>(x) + dx;
                const auto there = [&](std::size_t column) { return hn::LoadU(d, beside + column * around.stride); };
                const V other_opacity = there(opacity);
                const auto counts = hn::And(hn::Gt(other_opacity, zero), hn::And(are_alike(own_far, there(far_m)),
                                                                                 are_alike(own_near, there(near_m))));
                const V weight =
                    hn::IfThenElseZero(counts, hn::Set(d, share_at(dx, around.reach) * share_at(dy, around.reach)));
                for (std::size_t channel = 0; channel < 3; ++channel)
                    sum[channel] = hn::MulAdd(weight, there(radiance + channel), sum[channel]);
                if (has_patterned) {
                    const V share = hn::IfThenElseZero(
                        counts, hn::Set(d, share_here(dx, around.reach) * share_here(dy, around.reach)));
                    for (std::size_t channel = 0; channel < 3; ++channel) {
                        const V of_whole = there(unshadowed + channel);
                        shared[channel] = hn::MulAdd(weight, there(patterned + channel), shared[channel]);
                        whole[channel] = hn::MulAdd(weight, of_whole, whole[channel]);
                        kept[channel] = hn::MulAdd(share, of_whole, kept[channel]);
                    }
                    weight_here = hn::Add(weight_here, share);
                }
                if (around.has_visibility)
                    visibility_sum = hn::MulAdd(weight, there(visibility), visibility_sum);
                weight_sum = hn::Add(weight_sum, weight);
                opacity_sum = hn::MulAdd(weight, other_opacity, opacity_sum);
            }
        }
        // No sum is 0 where the pixel counts: it is like itself.
        const auto has_air = hn::Gt(own_opacity, zero);
        const V per_opacity = hn::Div(own_opacity, opacity_sum);
        for (std::size_t channel = 0; channel < 3; ++channel) {
            V found = hn::Mul(sum[channel], per_opacity);
            if (has_patterned) {
                const V of_pattern =
                    hn::Div(hn::Mul(hn::Div(shared[channel], whole[channel]), kept[channel]), weight_here);
                found = hn::IfThenElse(hn::Gt(whole[channel], zero), hn::Add(found, of_pattern), found);
            }
            hn::StoreU(hn::IfThenElseZero(has_air, found), d, light + channel * around.stride + x);
        }
        if (around.has_visibility)
            hn::StoreU(hn::IfThenElseZero(has_air, hn::Div(visibility_sum, weight_sum)), d, visible + x);
    }
}
} // namespace shared_strata_lanes

void add_shared_line_of(const shared_strata::LinesAround& around, float* light, float* visible) {
    if (around.has_patterned)
        shared_strata_lanes::add_line<true>(around, light, visible);
    else
        shared_strata_lanes::add_line<false>(around, light, visible);
}
} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::light_shafts {
HWY_EXPORT(add_shared_line_of);
namespace shared_strata {
void add_line(const LinesAround& around, float* light, float* visibility) {
    HWY_DYNAMIC_DISPATCH(add_shared_line_of)(around, light, visibility);
}
} // namespace shared_strata
} // namespace tyndall::light_shafts
#endif
