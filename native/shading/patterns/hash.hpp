// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers in [0, 1] that the bits of one to four numbers choose.
// Based on: Bob Jenkins, lookup3.c, 2006 (hashword's "mix" and "final"); for whole cells also Jarzynski and Olano, Hash
//           Functions for GPU Rendering, JCGT 9(3), 2020 (pcg2d to pcg4d).
// Differs:  of lookup3 only what one to four words need; the length is in bytes, and the seed is 13. The permuted
//           generators are signed, which shows in their shifts, and lose the sign last. Several results of one key are
//           that key extended, or its coordinates in another order: as Cycles has them, or no picture would agree.
// Bound:    7 rounds of three operations; 13 with four words.
#pragma once
#include "core/math.hpp"
#include <bit>
#include <cstdint>

namespace tyndall::patterns {
/// A point of one to four coordinates.
template <int N>
using Point = glm::vec<N, float, glm::defaultp>;
template <int N>
using Cell = glm::vec<N, std::int32_t, glm::defaultp>;

inline constexpr std::uint32_t hash_seed(std::uint32_t word_count) { return 0xdeadbeefu + 4 * word_count + 13u; }

/// lookup3's last step; the hash is `c`.
inline std::uint32_t final_mix(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const auto step = [](std::uint32_t& target, std::uint32_t source, int bits) {
        target = (target ^ source) - std::rotl(source, bits);
    };
    step(c, b, 14);
    step(a, c, 11);
    step(b, a, 25);
    step(c, b, 16);
    step(a, c, 4);
    step(b, a, 14);
    step(c, b, 24);
    return c;
}
inline std::uint32_t hash(std::uint32_t a) { return final_mix(hash_seed(1) + a, hash_seed(1), hash_seed(1)); }
inline std::uint32_t hash(std::uint32_t a, std::uint32_t b) {
    return final_mix(hash_seed(2) + a, hash_seed(2) + b, hash_seed(2));
}
inline std::uint32_t hash(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    return final_mix(hash_seed(3) + a, hash_seed(3) + b, hash_seed(3) + c);
}
inline std::uint32_t hash(std::uint32_t first, std::uint32_t second, std::uint32_t third, std::uint32_t fourth) {
    std::uint32_t a = hash_seed(4) + first, b = hash_seed(4) + second, c = hash_seed(4) + third;
    const auto step = [](std::uint32_t& target, std::uint32_t& source, std::uint32_t& other, int bits) {
        target = (target - source) ^ std::rotl(source, bits);
        source += other;
    };
    step(a, c, b, 4);
    step(b, a, c, 6);
    step(c, b, a, 8);
    step(a, c, b, 16);
    step(b, a, c, 19);
    step(c, b, a, 4);
    return final_mix(a + fourth, b, c);
}

/// In [0, 1], of the numbers' bits: 0 and -0 differ.
template <typename... Floats>
float random(Floats... key) {
    return static_cast<float>(hash(std::bit_cast<std::uint32_t>(key)...)) * (1.0f / 4294967295.0f);
}
inline float random(const Point<1>& key) { return random(key.x); }
inline float random(const Point<2>& key) { return random(key.x, key.y); }
inline float random(const Point<3>& key) { return random(key.x, key.y, key.z); }
inline float random(const Point<4>& key) { return random(key.x, key.y, key.z, key.w); }

/// A colour in [0, 1]^3.
inline Rgb random_colour(const Point<1>& k) { return {random(k), random(k.x, 1.0f), random(k.x, 2.0f)}; }
inline Rgb random_colour(const Point<2>& k) { return {random(k), random(k.x, k.y, 1.0f), random(k.x, k.y, 2.0f)}; }
inline Rgb random_colour(const Point<3>& k) {
    return {random(k), random(k.x, k.y, k.z, 1.0f), random(k.x, k.y, k.z, 2.0f)};
}
inline Rgb random_colour(const Point<4>& k) {
    return {random(k), random(k.z, k.x, k.w, k.y), random(k.w, k.z, k.y, k.x)};
}

/// A point in [0, 1]^N.
inline Point<1> random_point(const Point<1>& k) { return Point<1>(random(k)); }
inline Point<2> random_point(const Point<2>& k) { return {random(k), random(k.x, k.y, 1.0f)}; }
inline Point<3> random_point(const Point<3>& k) { return random_colour(k); }
inline Point<4> random_point(const Point<4>& k) {
    return {random(k), random(k.w, k.x, k.y, k.z), random(k.z, k.w, k.x, k.y), random(k.y, k.z, k.w, k.x)};
}
/// Two numbers of three, and of four.
inline vec2 random_pair(const Point<3>& k) { return {random(k), random(k.z, k.x, k.y)}; }
inline vec2 random_pair(const Point<4>& k) { return {random(k), random(k.z, k.x, k.w, k.y)}; }

/// The permuted generators, of a cell: in [0, 1]^N.
template <int N>
Point<N> permuted_point(const Cell<N>& cell) {
    using Words = glm::vec<N, std::uint32_t, glm::defaultp>;
    Words v = Words(cell) * 1664525u + 1013904223u;
    const auto stir = [&] {
        if constexpr (N == 2) {
            v.x += v.y * 1664525u;
            v.y += v.x * 1664525u;
        } else if constexpr (N == 3) {
            v.x += v.y * v.z;
            v.y += v.z * v.x;
            v.z += v.x * v.y;
        } else {
            v.x += v.y * v.w;
            v.y += v.z * v.x;
            v.z += v.x * v.y;
            v.w += v.y * v.z;
        }
    };
    stir();
    for (int axis = 0; axis < N; ++axis)
        v[axis] ^= static_cast<std::uint32_t>(static_cast<std::int32_t>(v[axis]) >> 16);
    stir();
    return Point<N>(v & 0x7fffffffu) * (1.0f / 2147483647.0f);
}
/// In [0, 1]^3; in space that is the point itself.
inline Rgb permuted_colour(const Cell<2>& cell) { return permuted_point<3>(Cell<3>(cell, 0)); }
inline Rgb permuted_colour(const Cell<3>& cell) { return permuted_point<3>(cell); }
inline Rgb permuted_colour(const Cell<4>& cell) { return Rgb(permuted_point<4>(cell)); }
} // namespace tyndall::patterns
