// SPDX-License-Identifier: GPL-3.0-or-later
// 128 bits that tell inputs apart: the name of a job whose parts lie in files.
// Based on: multiplication by odd constants and shifts, two lanes of 64 bits. Against accidents, not against forgers.
// Bound:    1 ns per 8 bytes.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <span>
#include <string>

namespace tyndall::voxel_dag {
class Fingerprint {
public:
    /// Appends the bytes of an array, and how many there are.
    void add(std::span<const std::byte> bytes) {
        add_word(bytes.size());
        for (std::size_t at = 0; at < bytes.size(); at += sizeof(std::uint64_t)) {
            std::uint64_t word = 0;
            std::memcpy(&word, bytes.data() + at, std::min(sizeof(word), bytes.size() - at));
            add_word(word);
        }
    }
    void add_word(std::uint64_t word) {
        for (std::size_t lane = 0; lane < lanes_.size(); ++lane) {
            lanes_[lane] = (lanes_[lane] ^ word) * factors[lane];
            lanes_[lane] ^= lanes_[lane] >> 29;
        }
    }
    [[nodiscard]] const std::array<std::uint64_t, 2>& value() const { return lanes_; }
    /// 32 digits, for names of files.
    [[nodiscard]] std::string text() const {
        std::array<char, 33> digits;
        std::snprintf(digits.data(), digits.size(), "%016llx%016llx", static_cast<unsigned long long>(lanes_[0]),
                      static_cast<unsigned long long>(lanes_[1]));
        return digits.data();
    }

private:
    static constexpr std::array<std::uint64_t, 2> factors{0x9e3779b97f4a7c15ull, 0xd6e8feb86659fd93ull};
    std::array<std::uint64_t, 2> lanes_{0x243f6a8885a308d3ull, 0x13198a2e03707344ull}; // digits of pi
};
} // namespace tyndall::voxel_dag
