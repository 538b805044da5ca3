// SPDX-License-Identifier: GPL-3.0-or-later
// Points of low discrepancy in the unit square: Sobol' points, shuffled and scrambled per seed. Of the first 2^k points
// of a seed exactly one lies in each of the 2^k boxes of any shape 2^-a x 2^-(k-a), for every k and a.
// Based on: Burley, Practical Hash-based Owen Scrambling, JCGT 10(1), 2020; the permutation's constants: Vegdahl, Building
//           a Better LK Hash, 2021.
// Differs:  pads pairs of dimensions by seeds, so that two dimensions of the Sobol' sequence are enough.
// Bound:    about 110 integer operations, no branch, no table: a loop over seeds becomes vector code.
#pragma once
#include "core/math.hpp"
#include "core/random.hpp"
#include <cstdint>

namespace tyndall {
[[nodiscard]] constexpr std::uint32_t reverse_bits(std::uint32_t value) {
    value = value >> 16 | value << 16;
    value = (value & 0xff00ff00u) >> 8 | (value & 0x00ff00ffu) << 8;
    value = (value & 0xf0f0f0f0u) >> 4 | (value & 0x0f0f0f0fu) << 4;
    value = (value & 0xccccccccu) >> 2 | (value & 0x33333333u) << 2;
    return (value & 0xaaaaaaaau) >> 1 | (value & 0x55555555u) << 1;
}

/// Owen scrambling of the bits in reversed order: a bit flips depending on those below it only.
[[nodiscard]] constexpr std::uint32_t laine_karras_permutation(std::uint32_t value, std::uint32_t seed) {
    value ^= value * 0x3d20adeau;
    value += seed;
    value *= (seed >> 16) | 1u;
    value ^= value * 0x05526c56u;
    value ^= value * 0x53a22864u;
    return value;
}
[[nodiscard]] constexpr std::uint32_t owen_scrambled(std::uint32_t value, std::uint32_t seed) {
    return reverse_bits(laine_karras_permutation(reverse_bits(value), seed));
}

/// Point `index` of the sequence of `seed`, in [0, 1)^2. Different seeds are independent: use one per pixel and pair of
/// dimensions, hash(pixel, dimension).
[[nodiscard]] constexpr vec2 sobol_point(std::uint32_t index, std::uint32_t seed) {
    // Shuffling the index by the same kind of permutation keeps the first 2^k points one net.
    const std::uint32_t shuffled = owen_scrambled(index, hash(seed));
    // The first dimension is the index reversed; the second multiplies it with Pascal's triangle modulo 2 first. Binomial
    // k over j is odd where the bits of j are among those of k (Lucas): one step per bit of a bit's place.
    std::uint32_t second = shuffled;
    second ^= second >> 1 & 0x55555555u;
    second ^= second >> 2 & 0x33333333u;
    second ^= second >> 4 & 0x0f0f0f0fu;
    second ^= second >> 8 & 0x00ff00ffu;
    second ^= second >> 16;
    // Scrambling needs the reversed values reversed back.
    const std::uint32_t x = reverse_bits(laine_karras_permutation(shuffled, hash(seed, 1u)));
    const std::uint32_t y = reverse_bits(laine_karras_permutation(second, hash(seed, 2u)));
    return {unit_float(x), unit_float(y)};
}
} // namespace tyndall
