// SPDX-License-Identifier: GPL-3.0-or-later
// Fields of any width, one after another, lowest bits first, in words of 64 bits (little-endian machines).
#pragma once
#include <bit>
#include <cstdint>
#include <cstring>
#include <vector>

namespace tyndall::voxel_dag {
static_assert(std::endian::native == std::endian::little);
inline constexpr std::uint32_t most_field_bits = 57; ///< What one unaligned load of 64 bits has in any case.

class BitWriter {
public:
    [[nodiscard]] std::uint64_t size() const { return size_; } ///< In bits.
    void clear() {
        words_.clear();
        last_ = size_ = 0;
    }
    /// `value` is below 2^width; up to 64 bits.
    void append(std::uint64_t value, std::uint32_t width) {
        const std::uint32_t used = size_ % 64;
        size_ += width;
        last_ |= value << used;
        if (used + width < 64)
            return;
        words_.push_back(last_);
        last_ = used == 0 ? 0 : value >> (64 - used);
    }
    void append(const BitWriter& other) {
        if (const std::size_t words = words_.size() + other.words_.size() + 1; other.size_ > size_)
            words_.reserve(words); // once, and not up to twice as many: a root's record is nearly all there is
        const std::uint32_t used = size_ % 64;
        if (used == 0) {
            words_.insert(words_.end(), other.words_.begin(), other.words_.end());
        } else {
            const std::size_t begin = words_.size();
            words_.resize(begin + other.words_.size());
            for (std::size_t i = 0; i < other.words_.size(); ++i) {
                words_[begin + i] = last_ | other.words_[i] << used;
                last_ = other.words_[i] >> (64 - used);
            }
        }
        size_ += 64 * other.words_.size();
        append(other.last_, other.size_ % 64);
    }
    /// With one word of zeros behind, so that read_bits() may load beyond the end.
    [[nodiscard]] std::vector<std::uint64_t> padded_words() && {
        if (size_ % 64 != 0)
            words_.push_back(last_);
        words_.push_back(0);
        return std::move(words_);
    }

private:
    std::vector<std::uint64_t> words_; ///< Those that are full.
    std::uint64_t last_ = 0, size_ = 0;
};

/// Up to most_field_bits from a bit on; at least one word lies behind the last field.
[[nodiscard]] inline std::uint64_t read_bits(const std::vector<std::uint64_t>& words, std::uint64_t bit,
                                             std::uint32_t width) {
    std::uint64_t loaded;
    std::memcpy(&loaded, reinterpret_cast<const unsigned char*>(words.data()) + bit / 8, sizeof(loaded));
    return loaded >> bit % 8 & ((std::uint64_t{1} << width) - 1);
}
} // namespace tyndall::voxel_dag
