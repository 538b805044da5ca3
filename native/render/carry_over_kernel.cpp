// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/carry_over_kernel.hpp"
#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/carry_over_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tyndall::render::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
static constexpr hn::CappedTag<float, 16> d;
static constexpr hn::RebindToSigned<decltype(d)> di;
static constexpr std::size_t lanes = hn::MaxLanes(d);
using V = hn::Vec<decltype(d)>;
using I = hn::Vec<decltype(di)>;
using light_shafts::ViewRay;

/// A line of squares, and how much of it there is in the pixels.
struct Line {
    const ViewRay* rays;
    const float* heterogeneity;
    float share;
};

static HWY_INLINE void add(const Line& line, I square, V near, V far_m, V& sum, V& weight_sum) {
    static_assert(sizeof(ViewRay) == 8 * sizeof(float));
    const V other_m = hn::GatherIndex(d, reinterpret_cast<const float*>(line.rays) + 7, hn::ShiftLeft<3>(square));
    const V value = hn::GatherIndex(d, line.heterogeneity, square);
    // Of two endless rays 0, of one a NaN.
    const V apart = hn::Div(hn::Abs(hn::Sub(far_m, other_m)), hn::Max(far_m, other_m));
    const V away = hn::IfThenZeroElse(hn::Eq(far_m, other_m), apart);
    const auto counts = hn::And(hn::And(hn::Lt(away, hn::Set(d, other_surface)), hn::Gt(near, hn::Zero(d))),
                                hn::Ne(value, hn::Set(d, light_shafts::dark_air)));
    const V weight = hn::Mul(near, hn::Sub(hn::Set(d, 1.0f), hn::Div(away, hn::Set(d, other_surface))));
    sum = hn::IfThenElse(counts, hn::Add(sum, hn::Mul(weight, value)), sum);
    weight_sum = hn::IfThenElse(counts, hn::Add(weight_sum, weight), weight_sum);
}

std::size_t carry_over_of(const PixelsBetweenSquares& pixels, std::span<const ViewRay> rays,
                          std::span<const Rgb> radiance, bool fills_dark, std::span<float> heterogeneity) {
    const V one = hn::Set(d, 1.0f), dark = hn::Set(d, light_shafts::dark_air);
    const I first_square = hn::Set(di, static_cast<std::int32_t>(pixels.first_square)),
            last_square = hn::Set(di, static_cast<std::int32_t>(pixels.end_square) - 1);
    const auto last_ray = hn::Set(di, static_cast<std::int32_t>(rays.size()) - 1);
    const std::array lines{Line{pixels.lower, pixels.lower_heterogeneity, 1.0f - pixels.share_y},
                           Line{pixels.upper, pixels.upper_heterogeneity, pixels.share_y}};
    std::size_t dark_count = 0;
    for (std::size_t i = 0; i < rays.size(); i += lanes) {
        const I number = hn::Min(hn::Iota(di, static_cast<std::int32_t>(i)), last_ray);
        const auto colour = [&](std::size_t channel) {
            return hn::GatherIndex(d, &radiance.front().x + channel,
                                   hn::Add(hn::Add(number, number), number)); // 3 floats each
        };
        auto is_asked = hn::FirstN(d, std::min(lanes, rays.size() - i));
        if (!fills_dark) {
            const auto is_black = hn::And(hn::And(hn::Eq(colour(0), hn::Zero(d)), hn::Eq(colour(1), hn::Zero(d))),
                                          hn::Eq(colour(2), hn::Zero(d)));
            is_asked = hn::AndNot(is_black, is_asked);
        }
        V value = one;
        if (!hn::AllFalse(d, is_asked)) {
            const V far_m =
                hn::GatherIndex(d, reinterpret_cast<const float*>(rays.data()) + 7, hn::ShiftLeft<3>(number));
            const V x = hn::ConvertTo(d, hn::Add(number, hn::Set(di, static_cast<std::int32_t>(pixels.x))));
            const V at = hn::Min(hn::Max(hn::Div(hn::Sub(x, hn::Set(d, static_cast<float>(pixels.side / 2))),
                                                 hn::Set(d, static_cast<float>(pixels.side))),
                                         hn::ConvertTo(d, first_square)),
                                 hn::ConvertTo(d, last_square));
            const I before = hn::ConvertTo(di, at), after = hn::Min(hn::Add(before, hn::Set(di, 1)), last_square);
            const V share_x = hn::Sub(at, hn::ConvertTo(d, before));
            V sum = hn::Zero(d), weight_sum = sum;
            for (const Line& line : lines) {
                const V share = hn::Set(d, line.share);
                add(line, hn::Sub(before, first_square), hn::Mul(hn::Sub(one, share_x), share), far_m, sum, weight_sum);
                add(line, hn::Sub(after, first_square), hn::Mul(share_x, share), far_m, sum, weight_sum);
            }
            const V found =
                hn::IfThenElse(hn::Gt(weight_sum, hn::Set(d, least_neighbour_weight)), hn::Div(sum, weight_sum), dark);
            value = hn::IfThenElse(is_asked, found, one);
            dark_count += hn::CountTrue(d, hn::And(is_asked, hn::Eq(value, dark)));
        }
        if (rays.size() - i >= lanes) {
            hn::StoreU(value, d, &heterogeneity[i]);
        } else {
            alignas(64) float last[lanes];
            hn::Store(value, d, last);
            std::copy_n(last, rays.size() - i, heterogeneity.begin() + static_cast<std::ptrdiff_t>(i));
        }
    }
    return dark_count;
}
} // namespace tyndall::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::render {
HWY_EXPORT(carry_over_of);
std::size_t carry_over(const PixelsBetweenSquares& pixels, std::span<const light_shafts::ViewRay> rays,
                       std::span<const Rgb> radiance, bool fills_dark, std::span<float> heterogeneity) {
    return rays.empty() ? 0 : HWY_DYNAMIC_DISPATCH(carry_over_of)(pixels, rays, radiance, fills_dark, heterogeneity);
}
} // namespace tyndall::render
#endif
