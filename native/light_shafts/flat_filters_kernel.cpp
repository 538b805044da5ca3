// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/flat_filters_kernel.hpp"
#include <algorithm>
#include <array>
#include <bit>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "light_shafts/flat_filters_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// After it: once per target.
#include "light_shafts/extremes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::flat_filters::HWY_NAMESPACE {
/// Lines are cut into stretches of `width`; a window is the end of one and the beginning of the next.
template <typename Extreme>
static void running_extreme_in_strip(float* rows, std::size_t count, std::size_t width) {
    constexpr std::size_t together = 4; // vectors: their chains of comparisons hide one another's latency
    const std::size_t step = together * hn::Lanes(d);
    for (std::size_t stretch = 0; stretch < count; stretch += width) {
        for (std::size_t column = 0; column < strip_width; column += step) {
            const auto at = [&](std::size_t line, std::size_t i) {
                return rows + line * strip_width + column + i * hn::Lanes(d);
            };
            const std::size_t last = stretch + width - 1;
            V extreme[together];
            for (std::size_t i = 0; i < together; ++i)
                extreme[i] = hn::Load(d, at(last, i));
            for (std::size_t line = last; line-- > stretch;)
                for (std::size_t i = 0; i < together; ++i) {
                    extreme[i] = Extreme::of(extreme[i], hn::Load(d, at(line, i)));
                    hn::Store(extreme[i], d, at(line, i));
                }
            const std::size_t end = std::min(stretch + width, count);
            if (stretch + 1 >= end)
                continue;
            for (std::size_t i = 0; i < together; ++i)
                extreme[i] = hn::Load(d, at(stretch + width, i));
            for (std::size_t line = stretch + 1;; ++line) {
                for (std::size_t i = 0; i < together; ++i)
                    hn::Store(Extreme::of(hn::Load(d, at(line, i)), extreme[i]), d, at(line, i));
                if (line + 1 == end)
                    break;
                for (std::size_t i = 0; i < together; ++i)
                    extreme[i] = Extreme::of(extreme[i], hn::Load(d, at(line + width, i)));
            }
        }
    }
}
void running_extreme_down_of(bool is_dilation, float* rows, std::size_t count, std::size_t width) {
    if (is_dilation)
        running_extreme_in_strip<Largest>(rows, count, width);
    else
        running_extreme_in_strip<Smallest>(rows, count, width);
}

template <typename Extreme>
static void spread(const Disc& disc, DoubledRow& row, float* const* outputs) {
    constexpr std::size_t together = 8; // vectors: a line is looked up once for all of them
    const std::size_t lanes = hn::Lanes(d), reach = disc.half_widths[0], width = disc_tile_width + 2 * reach;
    const auto level_of = [&](std::size_t half_width) { // of the widest that is no wider than the chord
        return static_cast<std::size_t>(std::bit_width(2 * half_width + 1)) - 1;
    };
    for (std::size_t level = 0; level < level_of(reach); ++level) {
        const std::size_t half = std::size_t{1} << level;
        const float* halves = row.values.data() + level * row.stride;
        for (std::size_t x = 0; x + 2 * half <= width; x += lanes)
            hn::StoreU(Extreme::of(hn::LoadU(d, halves + x), hn::LoadU(d, halves + x + half)), d,
                       row.values.data() + (level + 1) * row.stride + x);
    }
    const float* columns = row.values.data() + reach;
    for (std::size_t dy = 0; dy <= disc.radius;) { // chord by chord, nearest rows first
        const std::size_t chord = disc.of_row[dy], half_width = disc.half_widths[chord], level = level_of(half_width);
        std::size_t end = dy + 1;
        while (end <= disc.radius && disc.of_row[end] == chord)
            ++end;
        const float* left = columns + level * row.stride - half_width;
        const float* right = left + 2 * half_width + 1 - (std::size_t{1} << level);
        for (std::size_t x = 0; x < disc_tile_width; x += together * lanes) {
            V extreme[together];
            for (std::size_t i = 0; i < together; ++i)
                extreme[i] = Extreme::of(hn::LoadU(d, left + x + i * lanes), hn::LoadU(d, right + x + i * lanes));
            const auto spread_to = [&](float* output) {
                for (std::size_t i = 0; i < together; ++i) {
                    float* to = output + x + i * lanes;
                    hn::Store(Extreme::of(hn::Load(d, to), extreme[i]), d, to);
                }
            };
            for (std::size_t row_away = dy; row_away < end; ++row_away) {
                spread_to(outputs[disc.radius + row_away]);
                if (row_away > 0)
                    spread_to(outputs[disc.radius - row_away]);
            }
        }
        dy = end;
    }
}
void spread_row_of(bool is_dilation, const Disc& disc, DoubledRow& row, float* const* outputs) {
    if (is_dilation)
        spread<Largest>(disc, row, outputs);
    else
        spread<Smallest>(disc, row, outputs);
}
} // namespace tyndall::light_shafts::flat_filters::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::light_shafts::flat_filters {
HWY_EXPORT(running_extreme_down_of);
HWY_EXPORT(spread_row_of);

void running_extreme_down(bool is_dilation, float* rows, std::size_t count, std::size_t width) {
    HWY_DYNAMIC_DISPATCH(running_extreme_down_of)(is_dilation, rows, count, width);
}
void spread_row(bool is_dilation, const Disc& disc, DoubledRow& row, float* const* outputs) {
    HWY_DYNAMIC_DISPATCH(spread_row_of)(is_dilation, disc, row, outputs);
}
} // namespace tyndall::light_shafts::flat_filters
#endif
