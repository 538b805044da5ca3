// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/heterogeneity_kernel.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "light_shafts/heterogeneity_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// After it: once per target.
#include "light_shafts/exp-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
using StepTag = hn::CappedTag<float, 16>;
static constexpr StepTag steps_tag;

template <int channels>
static void add_channels(const ScatterPiece& piece, float weight, const air_steps::StepSpan& steps) {
    const auto d = steps_tag;
    const auto set = [&](float value) { return hn::Set(d, value); };
    const auto light_at = [&](auto at_m) {
        const auto away_m = hn::Sub(at_m, set(piece.near_m));
        auto sum = hn::Zero(d);
        for (int c = 0; c < channels; ++c) {
            const float source = channels == 1 ? weight * piece.source_per_m[0] : weight * piece.source_per_m[c] / 3.0f;
            const auto depth = hn::MulAdd(set(piece.depth_per_m[c]), away_m, set(piece.depth_at_near[c]));
            sum = hn::MulAdd(exp_of(d, hn::Neg(depth)), set(source), sum);
        }
        return sum;
    };
    const std::size_t lanes_count = hn::Lanes(d), whole = steps.count / lanes_count * lanes_count;
    for (std::size_t i = 0; i < whole; i += lanes_count) {
        const auto share = hn::LoadU(d, steps.shares + i);
        if (hn::AllTrue(d, hn::Eq(share, hn::Zero(d))))
            continue;
        const auto light = light_at(hn::LoadU(d, steps.at_m + i));
        hn::StoreU(hn::MulAdd(light, share, hn::LoadU(d, steps.weights + i)), d, steps.weights + i);
    }
    for (std::size_t i = whole; i < steps.count; ++i)
        if (steps.shares[i] != 0.0f)
            steps.weights[i] += steps.shares[i] * hn::GetLane(light_at(set(steps.at_m[i])));
}

void add_piece_of(const ScatterPiece& piece, float weight, const air_steps::StepSpan& steps) {
    const auto is_grey = [](const Rgb& value) { return value.x == value.y && value.y == value.z; };
    if (is_grey(piece.source_per_m) && is_grey(piece.depth_at_near) && is_grey(piece.depth_per_m))
        add_channels<1>(piece, weight, steps);
    else
        add_channels<3>(piece, weight, steps);
}
} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::light_shafts {
HWY_EXPORT(add_piece_of);
namespace air_steps {
void add_piece(const ScatterPiece& piece, float weight, const StepSpan& steps) {
    HWY_DYNAMIC_DISPATCH(add_piece_of)(piece, weight, steps);
}
} // namespace air_steps
} // namespace tyndall::light_shafts
#endif
