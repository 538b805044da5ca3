// SPDX-License-Identifier: GPL-3.0-or-later
// Counting and finding set bits in a row of bits that begins anywhere.
// Bound:    64 bits per step; touches 8 bytes behind the byte of the last bit, the zeros that bit_packing.hpp asks for.
#pragma once
#include "voxel_dag/bit_packing.hpp"
#include <algorithm>

namespace tyndall::voxel_dag {
/// The 64 bits from bit `position` on.
[[nodiscard]] inline std::uint64_t read_word(const std::uint8_t* bytes, std::uint64_t position) {
    const std::uint32_t shift = position & 7;
    std::uint64_t word;
    std::memcpy(&word, bytes + (position >> 3), sizeof(word));
    return shift == 0 ? word : word >> shift | std::uint64_t{bytes[(position >> 3) + 8]} << (64 - shift);
}

/// Of the bits [begin, end).
[[nodiscard]] inline std::uint32_t count_ones(const std::uint8_t* bytes, std::uint64_t begin, std::uint64_t end) {
    int count = 0;
    for (; begin + 64 <= end; begin += 64)
        count += std::popcount(read_word(bytes, begin));
    if (begin < end)
        count += std::popcount(read_word(bytes, begin) & low_bits(static_cast<std::uint32_t>(end - begin)));
    return static_cast<std::uint32_t>(count);
}

/// Position of set bit number `rank` of a word that has more.
[[nodiscard]] inline std::uint32_t find_one_in_word(std::uint64_t word, std::uint32_t rank) {
    std::uint32_t position = 0;
    for (const std::uint32_t half : {32u, 16u, 8u}) {
        const auto below = static_cast<std::uint32_t>(std::popcount(word & low_bits(half)));
        if (rank >= below) {
            rank -= below;
            word >>= half;
            position += half;
        }
    }
    for (; rank > 0; --rank)
        word &= word - 1;
    return position + static_cast<std::uint32_t>(std::countr_zero(word));
}

/// Position of set bit number `rank`, from 0 on, among [begin, end); `end` where there are not so many.
[[nodiscard]] inline std::uint64_t find_one(const std::uint8_t* bytes, std::uint64_t begin, std::uint64_t end,
                                            std::uint32_t rank) {
    for (; begin < end; begin += 64) {
        const std::uint64_t word = read_word(bytes, begin);
        if (const auto count = static_cast<std::uint32_t>(std::popcount(word)); rank >= count) {
            rank -= count;
            continue;
        }
        return std::min(end, begin + find_one_in_word(word, rank));
    }
    return end;
}
} // namespace tyndall::voxel_dag
