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
static_assert(sizeof(ViewRay) == 8 * sizeof(float) && sizeof(Rgb) == 3 * sizeof(float));
static_assert(lanes <= PixelsBetweenSquares::padding);

/// A line of squares, and how much of it there is in the pixels.
struct Line {
    const float *far_m, *heterogeneity;
    float share;
};

static HWY_INLINE void add(V other_m, V value, V near, V far_m, V& sum, V& weight_sum) {
    const V apart =
        hn::Div(hn::Abs(hn::Sub(far_m, other_m)), hn::Mul(hn::Set(d, other_surface), hn::Max(far_m, other_m)));
    const V agrees = hn::IfThenElse(hn::Eq(far_m, other_m), hn::Set(d, 1.0f), hn::Sub(hn::Set(d, 1.0f), apart));
    const auto counts = hn::And(hn::And(hn::Gt(agrees, hn::Zero(d)), hn::Gt(near, hn::Zero(d))),
                                hn::Ne(value, hn::Set(d, light_shafts::dark_air)));
    const V weight = hn::IfThenElseZero(counts, hn::Mul(near, agrees));
    sum = hn::IfThenElse(counts, hn::Add(sum, hn::Mul(weight, value)), sum);
    weight_sum = hn::Add(weight_sum, weight);
}

std::size_t carry_over_of(const PixelsBetweenSquares& pixels, std::span<const ViewRay> rays,
                          std::span<const Rgb> radiance, bool fills_dark, std::span<float> heterogeneity) {
    const V one = hn::Set(d, 1.0f), dark = hn::Set(d, light_shafts::dark_air);
    const I first_square = hn::Set(di, static_cast<std::int32_t>(pixels.first_square)),
            last_square = hn::Set(di, static_cast<std::int32_t>(pixels.end_square) - 1);
    const auto last_ray = hn::Set(di, static_cast<std::int32_t>(rays.size()) - 1);
    const std::array lines{Line{pixels.lower_far_m, pixels.lower_heterogeneity, 1.0f - pixels.share_y},
                           Line{pixels.upper_far_m, pixels.upper_heterogeneity, pixels.share_y}};
    const float per_side = 1.0f / static_cast<float>(pixels.side);
    std::size_t dark_count = 0;
    for (std::size_t i = 0; i < rays.size(); i += lanes) {
        const I number = hn::Min(hn::Iota(di, static_cast<std::int32_t>(i)), last_ray);
        auto is_asked = hn::FirstN(d, std::min(lanes, rays.size() - i));
        if (!fills_dark) {
            V red, green, blue;
            if (rays.size() - i >= lanes) {
                hn::LoadInterleaved3(d, &radiance[i].x, red, green, blue);
            } else {
                const float* const first = &radiance.front().x;
                const I place = hn::Add(hn::Add(number, number), number);
                red = hn::GatherIndex(d, first, place), green = hn::GatherIndex(d, first + 1, place),
                blue = hn::GatherIndex(d, first + 2, place);
            }
            const auto is_black =
                hn::And(hn::And(hn::Eq(red, hn::Zero(d)), hn::Eq(green, hn::Zero(d))), hn::Eq(blue, hn::Zero(d)));
            is_asked = hn::AndNot(is_black, is_asked);
        }
        V value = one;
        if (!hn::AllFalse(d, is_asked)) {
            const V far_m =
                hn::GatherIndex(d, reinterpret_cast<const float*>(rays.data()) + 7, hn::ShiftLeft<3>(number));
            const V x = hn::ConvertTo(d, hn::Add(number, hn::Set(di, static_cast<std::int32_t>(pixels.x))));
            const V at = hn::Min(
                hn::Max(hn::Mul(hn::Sub(x, hn::Set(d, static_cast<float>(pixels.side / 2))), hn::Set(d, per_side)),
                        hn::ConvertTo(d, first_square)),
                hn::ConvertTo(d, last_square));
            const I before = hn::ConvertTo(di, at), after = hn::Min(hn::Add(before, hn::Set(di, 1)), last_square);
            const V share_x = hn::Sub(at, hn::ConvertTo(d, before));
            V sum = hn::Zero(d), weight_sum = sum;
            // Squares of at least two pixels: those of a vector of pixels fit into one of squares.
            const std::int32_t least = hn::GetLane(before);
            const auto from = static_cast<std::size_t>(least) - pixels.first_square;
            const auto in_before = hn::IndicesFromVec(d, hn::Sub(before, hn::Set(di, least))),
                       in_after = hn::IndicesFromVec(d, hn::Sub(after, hn::Set(di, least)));
            for (const Line& line : lines) {
                const V share = hn::Set(d, line.share);
                const V other_m = hn::LoadU(d, line.far_m + from), known = hn::LoadU(d, line.heterogeneity + from);
                add(hn::TableLookupLanes(other_m, in_before), hn::TableLookupLanes(known, in_before),
                    hn::Mul(hn::Sub(one, share_x), share), far_m, sum, weight_sum);
                add(hn::TableLookupLanes(other_m, in_after), hn::TableLookupLanes(known, in_after),
                    hn::Mul(share_x, share), far_m, sum, weight_sum);
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
