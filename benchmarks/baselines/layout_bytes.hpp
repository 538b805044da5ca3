// SPDX-License-Identifier: GPL-3.0-or-later
// What the published layouts share: bytes as a file holds them, little-endian, and their reading in place.
// Each layout is a class with encode(), which makes the file's bytes, and a constructor that takes them; root_of, opened,
// child_of, leaf_of, groups_of and group_of beside it are what trace_through.hpp and decoded_bricks.hpp follow it by.
#pragma once
#include <bit>
#include <cstdint>
#include <cstring>
#include <vector>

namespace tyndall::baselines {
static_assert(std::endian::native == std::endian::little);
using Bytes = std::vector<std::uint8_t>;

template <class Number>
void append(Bytes& bytes, Number number) {
    const std::size_t at = bytes.size();
    bytes.resize(at + sizeof(Number));
    std::memcpy(bytes.data() + at, &number, sizeof(Number));
}
/// The lowest `width` bytes of a number.
inline void append(Bytes& bytes, std::uint64_t number, std::uint32_t width) {
    for (; width > 0; --width, number >>= 8)
        bytes.push_back(static_cast<std::uint8_t>(number));
}
template <class Number>
[[nodiscard]] Number number_at(const Bytes& bytes, std::size_t at) {
    Number number;
    std::memcpy(&number, bytes.data() + at, sizeof(Number));
    return number;
}
/// Of the children before one.
[[nodiscard]] inline std::uint32_t rank_of(std::uint32_t child_mask, std::uint32_t octant) {
    return static_cast<std::uint32_t>(std::popcount(child_mask & ((1u << octant) - 1)));
}
} // namespace tyndall::baselines
