// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers of any width in a row of bits, lowest bits first: little-endian bytes on every machine.
// Bound:    reading is one unaligned load, which may touch 7 bytes behind the number: what is read ends in 8 bytes of 0.
#pragma once
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

namespace tyndall::voxel_dag {
static_assert(std::endian::native == std::endian::little, "read_bits() loads words as they lie");

inline constexpr std::uint64_t bit_slack_bytes = 8;   ///< Zeros behind the last bit that is read.
inline constexpr std::uint32_t most_packed_bits = 57; ///< Of one number: 64 less 7, where its first byte is shared.

/// Bits that numbers below `count` need; 0 for one number.
[[nodiscard]] constexpr std::uint32_t bits_for(std::uint64_t count) {
    return count <= 1 ? 0 : static_cast<std::uint32_t>(std::bit_width(count - 1));
}
[[nodiscard]] constexpr std::uint64_t low_bits(std::uint32_t width) {
    return width >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << width) - 1;
}

/// The number of `width` bits, at most most_packed_bits, from bit `position` on.
[[nodiscard]] inline std::uint64_t read_bits(const std::uint8_t* bytes, std::uint64_t position, std::uint32_t width) {
    std::uint64_t word;
    std::memcpy(&word, bytes + (position >> 3), sizeof(word));
    return word >> (position & 7) & low_bits(width);
}

class BitPacker {
public:
    [[nodiscard]] std::uint64_t bit_count() const { return 8 * bytes_.size() + held_bits_; }
    /// value is below 2^width; width is at most most_packed_bits.
    void append(std::uint64_t value, std::uint32_t width) {
        held_ |= value << held_bits_; // fewer than 64 bits are held
        held_bits_ += width;
        if (held_bits_ >= 64) {
            const std::size_t at = bytes_.size();
            bytes_.resize(at + sizeof(held_));
            std::memcpy(bytes_.data() + at, &held_, sizeof(held_));
            held_bits_ -= 64;
            held_ = value >> (width - held_bits_); // width is 1 at least, or nothing would have been full
        }
    }
    /// `count` times the same number.
    void append_run(std::uint64_t value, std::uint32_t width, std::uint64_t count) {
        if (width == 0)
            return;
        const std::uint64_t together = 56 / width;
        if (together > 1 && count > together) {
            std::uint64_t pattern = 0;
            for (std::uint64_t i = 0; i < together; ++i)
                pattern |= value << i * width;
            for (; count >= together; count -= together)
                append(pattern, static_cast<std::uint32_t>(together) * width);
        }
        for (; count > 0; --count)
            append(value, width);
    }
    /// The first bits of a row.
    void append_bits(std::span<const std::uint8_t> row, std::uint64_t count) {
        for (std::size_t byte = 0; count > 0; ++byte) {
            const auto width = static_cast<std::uint32_t>(count < 8 ? count : 8);
            append(row[byte] & low_bits(width), width);
            count -= width;
        }
    }
    /// The whole words so far, which are forgotten: bit_count() is that of what is left.
    [[nodiscard]] std::vector<std::uint8_t> take_words() { return std::exchange(bytes_, {}); }
    /// Up to the next byte with zeros; the bytes so far.
    [[nodiscard]] std::vector<std::uint8_t> take() {
        for (; held_bits_ > 0; held_bits_ -= held_bits_ < 8 ? held_bits_ : 8, held_ >>= 8)
            bytes_.push_back(static_cast<std::uint8_t>(held_));
        held_ = 0;
        return std::exchange(bytes_, {});
    }

private:
    std::vector<std::uint8_t> bytes_;
    std::uint64_t held_ = 0;
    std::uint32_t held_bits_ = 0; // fewer than 64 between calls
};
} // namespace tyndall::voxel_dag
