// SPDX-License-Identifier: GPL-3.0-or-later
// The angle that kernels choose by: light_tree_along.cpp and glow_cells.cpp include this inside their namespace, once per
// SIMD target.

/// Of over / under, from 0 to pi, for `over` of 0 or more; to 0.005 rad.
template <class D, class Vector = hwy::HWY_NAMESPACE::Vec<D>>
static HWY_INLINE Vector arctangent(D d, Vector over, Vector under) {
    namespace hn = hwy::HWY_NAMESPACE;
    const Vector size = hn::Abs(under);
    const Vector ratio = hn::Min(size, over) / hn::Max(hn::Max(size, over), hn::Set(d, 1e-30f));
    const Vector small = ratio / hn::MulAdd(hn::Set(d, 0.28f) * ratio, ratio, hn::Set(d, 1.0f));
    const Vector sharp =
        hn::IfThenElse(hn::Gt(over, size), hn::Set(d, 0.5f * std::numbers::pi_v<float>) - small, small);
    return hn::IfThenElse(hn::Lt(under, hn::Zero(d)), hn::Set(d, std::numbers::pi_v<float>) - sharp, sharp);
}
