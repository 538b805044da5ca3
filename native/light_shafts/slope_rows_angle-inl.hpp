// SPDX-License-Identifier: GPL-3.0-or-later
// atan2 on vectors, compiled once per SIMD target: include after hwy/highway.h, inside foreach_target's passes.
// Based on: Cephes atanf (Moshier): one division, reduction at tan(pi/8), odd polynomial; 3e-7 rad.
#if defined(TYNDALL_SLOPE_ROWS_ANGLE_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TYNDALL_SLOPE_ROWS_ANGLE_INL
#undef TYNDALL_SLOPE_ROWS_ANGLE_INL
#else
#define TYNDALL_SLOPE_ROWS_ANGLE_INL
#endif
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D, class V = hn::Vec<D>>
HWY_INLINE V atan2_of(D d, V y, V x) {
    const V ax = hn::Abs(x), ay = hn::Abs(y);
    const V low = hn::Min(ax, ay), high = hn::Max(ax, ay);
    const auto is_reduced = hn::Gt(low, hn::Mul(hn::Set(d, 0.41421356f), high));
    const V numerator = hn::IfThenElse(is_reduced, hn::Sub(low, high), low);
    const V denominator = hn::IfThenElse(is_reduced, hn::Add(low, high), high);
    // atan2(0, 0) is 0: any slice is as good as another on the axis
    const V t = hn::Div(numerator, hn::Max(denominator, hn::Set(d, 1e-37f)));
    const V z = hn::Mul(t, t);
    V p = hn::MulAdd(hn::Set(d, 8.05374449538e-2f), z, hn::Set(d, -1.38776856032e-1f));
    p = hn::MulAdd(p, z, hn::Set(d, 1.99777106478e-1f));
    p = hn::MulAdd(p, z, hn::Set(d, -3.33329491539e-1f));
    V angle = hn::MulAdd(hn::Mul(p, z), t, t);
    angle = hn::IfThenElse(is_reduced, hn::Add(angle, hn::Set(d, pi / 4)), angle);
    angle = hn::IfThenElse(hn::Gt(ay, ax), hn::Sub(hn::Set(d, pi / 2), angle), angle);
    angle = hn::IfThenElse(hn::Lt(x, hn::Zero(d)), hn::Sub(hn::Set(d, pi), angle), angle);
    return hn::CopySign(angle, y);
}
} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
