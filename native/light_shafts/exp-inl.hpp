// SPDX-License-Identifier: GPL-3.0-or-later
// exp, reciprocals and roots on vectors of floats, compiled once per SIMD target: include after hwy/highway.h, inside
// foreach_target's passes.
// Based on: Cephes expf (Moshier), the reduction; Newton's step on the CPU's approximations, which a division would wait for.
#if defined(TYNDALL_EXP_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TYNDALL_EXP_INL
#undef TYNDALL_EXP_INL
#else
#define TYNDALL_EXP_INL
#endif
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tyndall::light_shafts::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// exp(x), relative error 2e-7; exp(-87) below -87, no more than exp(80).
template <class D, class V = hn::Vec<D>>
HWY_INLINE V exp_of(D d, V x) {
    const hn::RebindToSigned<D> di;
    x = hn::Min(hn::Max(x, hn::Set(d, -87.0f)), hn::Set(d, 80.0f));
    // Beside 1.5 * 2^23 a float's last bits count whole numbers: rounded, and as an exponent, without a conversion.
    const V magic = hn::Set(d, 12582912.0f);
    const V rounded = hn::MulAdd(x, hn::Set(d, 1.44269504f), magic), n = hn::Sub(rounded, magic);
    V f = hn::NegMulAdd(n, hn::Set(d, 0.693359375f), x);
    f = hn::MulAdd(n, hn::Set(d, 2.12194440e-4f), f);
    // The least relative error, 1.05e-7, of those that begin with 1 + f.
    V p = hn::MulAdd(hn::Set(d, 8.3125e-3f), f, hn::Set(d, 4.189033e-2f));
    p = hn::MulAdd(p, f, hn::Set(d, 0.16667115f));
    p = hn::MulAdd(p, f, hn::Set(d, 0.4999923f));
    p = hn::MulAdd(hn::MulAdd(p, f, hn::Set(d, 1.0f)), f, hn::Set(d, 1.0f));
    return hn::BitCast(d, hn::Add(hn::BitCast(di, p), hn::ShiftLeft<23>(hn::BitCast(di, rounded))));
}

/// 1 / x for normal x, relative error 3e-7.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V reciprocal_of(D d, V x) {
    const V r = hn::ApproximateReciprocal(x);
    return hn::Mul(r, hn::NegMulAdd(x, r, hn::Set(d, 2.0f)));
}

/// 1 / sqrt(x) for normal x > 0, relative error 3e-7.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V reciprocal_root_of(D d, V x) {
    const V r = hn::ApproximateReciprocalSqrt(x);
    const V half_x = hn::Mul(hn::Set(d, 0.5f), x);
    return hn::Mul(r, hn::NegMulAdd(hn::Mul(half_x, r), r, hn::Set(d, 1.5f)));
}
} // namespace tyndall::light_shafts::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
