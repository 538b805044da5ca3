// SPDX-License-Identifier: GPL-3.0-or-later
// hash.hpp's hashes, one per lane: for what is compiled once per instruction set.
// Based on: see hash.hpp.
// Differs:  see hash.hpp; the values are the same to the last bit.
#if defined(TYNDALL_HASH_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TYNDALL_HASH_LANES_INL
#undef TYNDALL_HASH_LANES_INL
#else
#define TYNDALL_HASH_LANES_INL
#endif
#include "shading/patterns/hash.hpp"
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace tyndall::patterns::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <int bits, typename W>
static HWY_INLINE W rotated(W words) {
    return hn::Or(hn::ShiftLeft<bits>(words), hn::ShiftRight<32 - bits>(words));
}
template <int bits, typename W>
static HWY_INLINE void stir(W& target, W source) {
    target = hn::Sub(hn::Xor(target, source), rotated<bits>(source));
}
template <int bits, typename W>
static HWY_INLINE void stir_more(W& target, W& source, W other) {
    target = hn::Xor(hn::Sub(target, source), rotated<bits>(source));
    source = hn::Add(source, other);
}
/// hash.hpp's, of one to four words per lane.
template <int N, typename D, typename W>
static HWY_INLINE W hash_of(D d, const W* words) {
    const W seed = hn::Set(d, hash_seed(N));
    W a = hn::Add(seed, words[0]), b = N > 1 ? hn::Add(seed, words[N > 1]) : seed;
    W c = N > 2 ? hn::Add(seed, words[N > 2 ? 2 : 0]) : seed;
    if constexpr (N == 4) {
        stir_more<4>(a, c, b);
        stir_more<6>(b, a, c);
        stir_more<8>(c, b, a);
        stir_more<16>(a, c, b);
        stir_more<19>(b, a, c);
        stir_more<4>(c, b, a);
        a = hn::Add(a, words[3]);
    }
    stir<14>(c, b);
    stir<11>(a, c);
    stir<25>(b, a);
    stir<16>(c, b);
    stir<4>(a, c);
    stir<14>(b, a);
    stir<24>(c, b);
    return c;
}

/// [0, 1], of the words' hash; rounded once, as a whole number is when it becomes a float.
template <int N, typename D, typename W>
static HWY_INLINE hn::Vec<D> random_of(D d, const W* words) {
    constexpr hn::RebindToUnsigned<D> du;
    constexpr hn::RebindToSigned<D> di;
    const W bits = hash_of<N>(du, words);
    const auto high = hn::ConvertTo(d, hn::BitCast(di, hn::ShiftRight<16>(bits)));
    const auto low = hn::ConvertTo(d, hn::BitCast(di, hn::And(bits, hn::Set(du, 0xffffu))));
    return hn::Mul(hn::Add(hn::Mul(high, hn::Set(d, 65536.0f)), low), hn::Set(d, 1.0f / 4294967295.0f));
}
} // namespace tyndall::patterns::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
