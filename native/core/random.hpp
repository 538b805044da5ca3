// SPDX-License-Identifier: GPL-3.0-or-later
// Random numbers by counter: a number is a hash of what it is for (pixel, sample, dimension, seed), never of what was
// drawn before, so that threads need no state and share no order.
// Based on: Jarzynski and Olano, Hash Functions for GPU Rendering, JCGT 9(3), 2020 (pcg4d); Wellons, Prospecting for Hash
//           Functions, 2018 (lowbias32).
// Bound:    a few multiplications each; pcg4d passes TestU01's BigCrush but for two linear tests.
#pragma once
#include <array>
#include <cstdint>

namespace tyndall {
/// A permutation of the 32-bit numbers that flips each output bit with probability 1/2 per input bit, to 1 part in 500.
[[nodiscard]] constexpr std::uint32_t hash(std::uint32_t value) {
    value ^= value >> 16;
    value *= 0x7feb352du;
    value ^= value >> 15;
    value *= 0x846ca68bu;
    value ^= value >> 16;
    return value;
}
/// Of several numbers, in their order.
template <typename... Rest>
[[nodiscard]] constexpr std::uint32_t hash(std::uint32_t first, std::uint32_t second, Rest... rest) {
    return hash(hash(first) ^ (second + 0x9e3779b9u), rest...);
}

/// Four numbers from four, each output depending on all inputs.
[[nodiscard]] constexpr std::array<std::uint32_t, 4> pcg4d(std::array<std::uint32_t, 4> v) {
    const auto mix = [&v] {
        v[0] += v[1] * v[3];
        v[1] += v[2] * v[0];
        v[2] += v[0] * v[1];
        v[3] += v[1] * v[2];
    };
    for (std::uint32_t& value : v)
        value = value * 1664525u + 1013904223u;
    mix();
    for (std::uint32_t& value : v)
        value ^= value >> 16;
    mix();
    return v;
}

/// The upper 24 bits as a float in [0, 1): every value is a float, 1 is never rounded to.
[[nodiscard]] constexpr float unit_float(std::uint32_t bits) { return static_cast<float>(bits >> 8) * 0x1p-24f; }
} // namespace tyndall
