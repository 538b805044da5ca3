// SPDX-License-Identifier: GPL-3.0-or-later
// The frame's linear functions and light lines on vectors, compiled once per SIMD target: include after hwy/highway.h,
// inside foreach_target's passes.
#if defined(TYNDALL_SLOPE_ROWS_FRAME_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TYNDALL_SLOPE_ROWS_FRAME_INL
#undef TYNDALL_SLOPE_ROWS_FRAME_INL
#else
#define TYNDALL_SLOPE_ROWS_FRAME_INL
#endif
#include "light_shafts/slope_rows_angle-inl.hpp"
#include "light_shafts/slope_rows_kernels.hpp"
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
using namespace slope_rows;
using Tag = hn::CappedTag<float, 16>;
using V = hn::Vec<Tag>;
using Mask = hn::Mask<Tag>;
static constexpr Tag d;
static constexpr hn::RebindToSigned<Tag> di;

static HWY_INLINE V set(float value) { return hn::Set(d, value); }
static HWY_INLINE V linear_at(const Linear& f, V a, V r) {
    return hn::MulAdd(set(f.per_axial), a, hn::MulAdd(set(f.per_radial), r, set(f.at_origin)));
}
static HWY_INLINE V line_at(const Frame& frame, V a, V r) {
    return frame.is_angular ? atan2_of(d, hn::Mul(set(frame.angle_scale), r), linear_at(frame.x, a, r)) : r;
}
} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
