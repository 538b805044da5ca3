// SPDX-License-Identifier: GPL-3.0-or-later
// Dilation and erosion, compiled once per SIMD target: what they keep of two values, and what leaves the other as it is.
#if defined(TYNDALL_EXTREMES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TYNDALL_EXTREMES_INL
#undef TYNDALL_EXTREMES_INL
#else
#define TYNDALL_EXTREMES_INL
#endif
#include "light_shafts/slope_rows.hpp"
#include <hwy/highway.h>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::flat_filters::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using Tag = hn::CappedTag<float, 16>;
using V = hn::Vec<Tag>;
static constexpr Tag d;

struct Largest {
    static constexpr float neutral = slope_rows::no_occluder;
    static HWY_INLINE V of(V a, V b) { return hn::Max(a, b); }
};
struct Smallest {
    static constexpr float neutral = std::numeric_limits<float>::infinity();
    static HWY_INLINE V of(V a, V b) { return hn::Min(a, b); }
};
} // namespace tyndall::light_shafts::flat_filters::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
