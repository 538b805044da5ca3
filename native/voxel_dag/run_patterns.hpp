// SPDX-License-Identifier: GPL-3.0-or-later
// How values change within 16 entries, as a code of a few bits: where they do, and where that is back to the value before
// last. Most groups of an array look like one of some hundreds.
//
//   entries   A A A A B B A A A B C C C C C C    A was there before
//   changes   0 0 0 0 1 0 1 0 0 1 1 0 0 0 0 0
//   returns               1     1                the others, B and C, take the next index each
//
// Based on: size classes as of a DAG's pointers by use (Kol 2018, 2.4.4; Jaspe 2018, 5.4.3).
// Differs:  changes and returns are one symbol: together they take 0.56 bits per entry of Sponza's baked colours, where bytes
//           of changes with a table per block and a bit per run take 0.75; 8 entries at once take 0.63. Patterns that are too
//           rare for the table are two halves, of which the most frequent have short names.
// Bound:    a code is a class of 3 bits and a number as wide as its class says; where it lies is the sum of the widths before,
//           so that no code waits for the one before to be read.
#pragma once
#include "voxel_dag/bit_packing.hpp"
#include <array>
#include <bit>
#include <unordered_map>

namespace tyndall::voxel_dag::run_patterns {
inline constexpr std::uint32_t log2_entries = 4, entries = 1u << log2_entries;

/// Bit i of the lower half: entry i differs from the one before. Of the upper half: it is what the run before last was.
using Pattern = std::uint32_t;
[[nodiscard]] constexpr std::uint32_t changes_of(Pattern pattern) { return pattern & 0xffff; }
[[nodiscard]] constexpr std::uint32_t returns_of(Pattern pattern) { return pattern >> entries; }

/// Of 8 entries, as 8 digits: 0, 1 for a change, 2 for a return; the first entry's lowest.
inline constexpr std::uint32_t half_entries = entries / 2, half_bits = 13, half_count = 6561; ///< 3^8.
/// Both halves' digits, the first half's in the lower 13 bits.
inline constexpr std::uint32_t digit_bits = 2 * half_bits;
[[nodiscard]] std::uint32_t digits_of(Pattern pattern);
[[nodiscard]] constexpr bool are_digits(std::uint32_t digits) {
    return (digits & low_bits(half_bits)) < half_count && digits >> half_bits < half_count;
}
/// Of digits that are some.
[[nodiscard]] Pattern pattern_of(std::uint32_t digits);

/// What a group makes of the runs before it: 0 stands for the last of them, 1 for the one before, 2 + i for the group's own
/// index i.
struct Effect {
    std::uint32_t last = 0, before = 1, new_count = 0;

    void change(bool is_return) {
        const std::uint32_t next = is_return ? before : 2 + new_count;
        before = last, last = next;
        new_count += !is_return;
    }
};
/// Of the changes up to an entry, and its own.
[[nodiscard]] Effect effect_of(Pattern pattern, std::uint32_t entry = entries - 1);

/// Patterns of the table, of four widths; then two halves, of which the first, the second or both may be wide.
inline constexpr std::uint32_t class_bits = 3, class_count = 1 << class_bits, ranked_count = 4;
/// Names for patterns, and for halves of those that have none.
struct Table {
    static constexpr std::uint32_t most_width = 15;

    std::array<std::uint32_t, ranked_count> widths{}; ///< Of a pattern's rank in each class, each up to most_width.
    std::vector<Pattern> patterns;                    ///< By rank.
    std::uint32_t narrow_width = 0;                   ///< Of a half's rank; other halves are half_bits wide.
    std::vector<std::uint32_t> halves;                ///< Digits by rank, at most 2^narrow_width.

    [[nodiscard]] std::array<std::uint32_t, ranked_count + 1> begins() const {
        std::array<std::uint32_t, ranked_count + 1> begins{};
        for (std::uint32_t at = 0; at < ranked_count; ++at)
            begins[at + 1] = begins[at] + (1u << widths[at]);
        return begins;
    }
};
/// One with which codes and the table itself take few bits. counts: of patterns that have changes.
[[nodiscard]] Table best_table(const std::unordered_map<Pattern, std::uint64_t>& counts);

struct Code {
    std::uint32_t of_class, value;
};
/// Bits of a code's value in each class.
class Widths {
public:
    Widths() = default;
    explicit Widths(const Table& table);
    [[nodiscard]] std::uint32_t width(std::uint32_t of_class) const { return widths_[of_class]; }

protected:
    [[nodiscard]] static constexpr bool is_wide(std::uint32_t of_class, std::uint32_t half) {
        return ((of_class - ranked_count) >> half & 1) != 0;
    }
    [[nodiscard]] std::uint32_t half_width(std::uint32_t of_class, std::uint32_t half) const {
        return is_wide(of_class, half) ? half_bits : narrow_width_;
    }

    std::array<std::uint32_t, class_count> widths_{};
    std::array<std::uint32_t, ranked_count + 1> begins_{};
    std::uint32_t narrow_width_ = 0;
};

class Writer : public Widths {
public:
    explicit Writer(const Table& table);
    [[nodiscard]] Code code_of(Pattern pattern) const;

private:
    std::unordered_map<Pattern, std::uint32_t> rank_of_;
    std::vector<std::uint32_t> rank_of_half_; ///< By digits; half_count: none.
};

class Reader : public Widths {
public:
    Reader() = default;
    explicit Reader(const Table& table);
    /// Codes that are not may be asked for, too: they have no change.
    [[nodiscard]] bool is_known(const Code& code) const {
        if (code.of_class < ranked_count)
            return begins_[code.of_class] + code.value < patterns_.size();
        return half_of(code, 0) < half_count && half_of(code, 1) < half_count;
    }
    [[nodiscard]] Pattern pattern(const Code& code) const {
        if (!is_known(code))
            return 0;
        return code.of_class < ranked_count ? patterns_[begins_[code.of_class] + code.value]
                                            : pattern_of(half_of(code, 0) | half_of(code, 1) << half_bits);
    }
    /// Indices that a group brings: all that of most codes has to be known. Two loads, whatever the class.
    [[nodiscard]] std::uint32_t new_count(const Code& code) const {
        const Parts& parts = parts_[code.of_class];
        return std::uint32_t{new_counts_[parts.first + (code.value & low_bits(parts.first_width))]} +
               new_counts_[parts.second + (code.value >> parts.first_width)];
    }

private:
    /// A half's digits; half_count and more: it is none.
    [[nodiscard]] std::uint32_t half_of(const Code& code, std::uint32_t half) const {
        const std::uint32_t shifted = half == 0 ? code.value : code.value >> half_width(code.of_class, 0);
        const auto value = static_cast<std::uint32_t>(shifted & low_bits(half_width(code.of_class, half)));
        return is_wide(code.of_class, half) ? value : halves_[value];
    }
    /// Where new_counts_ has those of what a code consists of.
    struct Parts {
        std::uint32_t first, first_width, second;
    };

    std::vector<Pattern> patterns_;
    std::vector<std::uint32_t> halves_; ///< Digits by rank, as many as there are ranks.
    /// Of patterns, of halves by rank, of halves by digits, and a 0: a byte each, so that they stay in the cache.
    std::vector<std::uint8_t> new_counts_;
    std::array<Parts, class_count> parts_{};
};
} // namespace tyndall::voxel_dag::run_patterns
