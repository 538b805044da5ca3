// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/row_extremes_kernel.hpp"
#include <algorithm>
#include <array>
#include <bit>
#include <type_traits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "light_shafts/row_extremes_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// After it: once per target.
#include "light_shafts/extremes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::flat_filters::HWY_NAMESPACE {
static constexpr std::size_t lanes = hn::MaxLanes(d), most_levels = std::bit_width(lanes) - 1;

/// `lanes` values from value n on of two vectors side by side; n is a power of two, at most half a vector.
template <std::size_t n>
static HWY_INLINE V values_from(V first, V second) {
#if HWY_TARGET <= HWY_AVX3
    return V{
        _mm512_castsi512_ps(_mm512_alignr_epi32(_mm512_castps_si512(second.raw), _mm512_castps_si512(first.raw), n))};
#else
    if constexpr (lanes == 4)
        return hn::CombineShiftRightBytes<4 * n>(d, second, first);
    else {
        const V middle = hn::ConcatLowerUpper(d, second, first);
        if constexpr (n == 4)
            return middle;
        else
            return hn::CombineShiftRightBytes<4 * n>(d, middle, first);
    }
#endif
}

/// Extremes of 2^levels values from each on: vectors of a row go in one after the other, and come out `levels` pushes later.
/// What lies before the first one is neutral.
template <typename Extreme, std::size_t levels>
class Windows {
public:
    HWY_INLINE Windows() {
        for (V& vector : before_)
            vector = hn::Set(d, Extreme::neutral);
    }
    HWY_INLINE V push(V vector) { return push_at<0>(vector); }

private:
    template <std::size_t level>
    HWY_INLINE V push_at(V second) {
        if constexpr (level == levels)
            return second;
        else {
            const V first = before_[level];
            before_[level] = second;
            return push_at<level + 1>(Extreme::of(first, values_from<std::size_t{1} << level>(first, second)));
        }
    }
    V before_[levels];
};

/// Extremes of wider windows from those of `of` values that `windows` holds.
template <typename Extreme, std::size_t offset_count>
struct Widened {
    std::array<std::size_t, offset_count> offsets; ///< All but the last one are multiples of a vector.
    HWY_INLINE V at(const float* windows) const {
        V extreme = hn::Load(d, windows);
        for (std::size_t i = 0; i + 1 < offset_count; ++i)
            extreme = Extreme::of(extreme, hn::Load(d, windows + offsets[i]));
        return Extreme::of(extreme, hn::LoadU(d, windows + offsets[offset_count - 1]));
    }
};
/// use(Widened) for the width; before, the windows of `of` values below `end` have grown to a quarter of it or more.
template <typename Extreme, typename Use>
static HWY_INLINE void widen(float* windows, std::size_t end, std::size_t of, std::size_t width, const Use& use) {
    for (; of * 4 <= width; of *= 4) {
        const Widened<Extreme, 3> four_times{{of, 2 * of, 3 * of}};
        for (std::size_t i = 0; i < end; i += lanes)
            hn::Store(four_times.at(windows + i), d, windows + i);
    }
    if (width <= 2 * of)
        use(Widened<Extreme, 1>{{width - of}});
    else if (width <= 3 * of)
        use(Widened<Extreme, 2>{{of, width - of}});
    else
        use(Widened<Extreme, 3>{{of, 2 * of, width - of}});
}

/// windows[i], for i below `end`, are the extremes of 2^levels values from i on of a row that begins at `begin`. What is
/// not of the row is neutral.
template <typename Extreme, std::size_t levels>
static void store_windows(const float* row, std::size_t count, std::size_t begin, float* windows, std::size_t end) {
    const std::size_t first = begin / lanes * lanes, row_end = begin + count;
    std::fill_n(windows, first, Extreme::neutral);
    Windows<Extreme, levels> neighbours;
    std::size_t i = first;
    const auto push = [&](V vector) {
        hn::Store(neighbours.push(vector), d, windows + i - levels * lanes);
        i += lanes;
    };
    const auto push_edge = [&] { // a vector that only a part of belongs to the row
        alignas(64) std::array<float, lanes> some;
        for (std::size_t lane = 0; lane < lanes; ++lane)
            some[lane] = begin <= i + lane && i + lane < row_end ? row[i + lane - begin] : Extreme::neutral;
        push(hn::Load(d, some.data()));
    };
    if (first < begin)
        push_edge();
    while (i + lanes <= row_end) {
        __builtin_prefetch(row + (i - begin) + count); // mostly the next row: it comes while this one is filtered
        push(hn::LoadU(d, row + (i - begin)));
    }
    if (i < row_end)
        push_edge();
    for (std::size_t level = 0; level < levels; ++level)
        push(hn::Set(d, Extreme::neutral));
    std::fill(windows + i - levels * lanes, windows + end, Extreme::neutral);
}

template <typename Widen>
static void store_row(const Widen& widened, const float* windows, std::size_t count, float* row) {
    const std::size_t whole = count / lanes * lanes;
    for (std::size_t i = 0; i < whole; i += lanes)
        hn::StoreU(widened.at(windows + i), d, row + i);
    if (whole < count) {
        alignas(64) std::array<float, lanes> some;
        hn::Store(widened.at(windows + whole), d, some.data());
        std::copy_n(some.data(), count - whole, row + whole);
    }
}

/// Where a row's windows lie in the scratch memory: pushes begin before them, and filters read behind them.
static constexpr std::size_t room_before = 64;
static std::size_t end_of_windows(std::size_t count, std::size_t width) {
    return (count + 2 * width + 15) / 16 * 16 + 32;
}

template <typename Extreme, std::size_t levels>
static void extremes_by(float* row, std::size_t count, const Window& window, float* scratch) {
    float* windows = scratch + room_before;
    store_windows<Extreme, levels>(row, count, window.before, windows, end_of_windows(count, window.width()));
    widen<Extreme>(windows, window.before + count, std::size_t{1} << levels, window.width(),
                   [&](const auto& widened) { store_row(widened, windows, count, row); });
}

// A window of the erosion ends where its value is; counted from its beginning, value c is number c, the row begins at
// width - 1, and so do the dilation's windows.
template <std::size_t levels>
static void close_by(float* row, std::size_t count, const Window& window, std::size_t centre_count, float* scratch) {
    const std::size_t width = window.width(), end = end_of_windows(count, width);
    const std::size_t dilated_begin = window.after, dilated_end = dilated_begin + centre_count;
    float* windows = scratch + room_before;
    float* eroded = windows + end + room_before;
    store_windows<Largest, levels>(row, count, width - 1, windows, end);
    const std::size_t first = dilated_begin / lanes * lanes, last = (dilated_end - 1) / lanes * lanes;
    std::fill_n(eroded, first, Smallest::neutral);
    const V neutral = hn::Set(d, Smallest::neutral);
    widen<Largest>(windows, width - 1 + count, std::size_t{1} << levels, width, [&](const auto& widened) {
        Windows<Smallest, levels> neighbours;
        float* to = eroded + first - levels * lanes;
        const auto push = [&](V vector) {
            hn::Store(neighbours.push(vector), d, to);
            to += lanes;
        };
        const auto push_edge = [&](std::size_t i) { // centres that do not exist
            V vector = widened.at(windows + i);
            if (i < dilated_begin)
                vector = hn::IfThenElse(hn::FirstN(d, dilated_begin - i), neutral, vector);
            push(hn::IfThenElse(hn::FirstN(d, dilated_end - i), vector, neutral));
        };
        push_edge(first);
        for (std::size_t i = first + lanes; i < last; i += lanes)
            push(widened.at(windows + i));
        if (first < last)
            push_edge(last);
        for (std::size_t level = 0; level < levels; ++level)
            push(neutral);
        std::fill(to, eroded + end, Smallest::neutral);
    });
    widen<Smallest>(eroded, dilated_end, std::size_t{1} << levels, width,
                    [&](const auto& widened) { store_row(widened, eroded, count, row); });
}

/// use(levels) for windows that are not wider than `width`, nor than a vector.
template <typename Use>
static HWY_INLINE void with_levels(std::size_t width, const Use& use) {
    const std::size_t levels = std::min<std::size_t>(most_levels, static_cast<std::size_t>(std::bit_width(width)) - 1);
    if (levels == 1)
        return use(std::integral_constant<std::size_t, 1>());
    if constexpr (most_levels > 2)
        if (levels == 2)
            return use(std::integral_constant<std::size_t, 2>());
    if constexpr (most_levels > 3)
        if (levels == 3)
            return use(std::integral_constant<std::size_t, 3>());
    use(std::integral_constant<std::size_t, most_levels>());
}

void extremes_of(bool is_dilation, float* row, std::size_t count, const Window& window, float* scratch) {
    with_levels(window.width(), [&](auto levels) {
        if (is_dilation)
            extremes_by<Largest, levels>(row, count, window, scratch);
        else
            extremes_by<Smallest, levels>(row, count, window, scratch);
    });
}
void close_of(float* row, std::size_t count, const Window& window, std::size_t centre_count, float* scratch) {
    with_levels(window.width(), [&](auto levels) { close_by<levels>(row, count, window, centre_count, scratch); });
}
} // namespace tyndall::light_shafts::flat_filters::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace tyndall::light_shafts::flat_filters {
HWY_EXPORT(extremes_of);
HWY_EXPORT(close_of);

void extremes_along(bool is_dilation, float* row, std::size_t count, const Window& window, float* scratch) {
    HWY_DYNAMIC_DISPATCH(extremes_of)(is_dilation, row, count, window, scratch);
}
void close_along(float* row, std::size_t count, const Window& window, std::size_t centre_count, float* scratch) {
    HWY_DYNAMIC_DISPATCH(close_of)(row, count, window, centre_count, scratch);
}
} // namespace tyndall::light_shafts::flat_filters
#endif
