// SPDX-License-Identifier: GPL-3.0-or-later
// How values change within 16 entries, as a code of a few bits: where they do, and where that is back to the value before
// last. Most groups of an array look like one of some hundreds.
//
//   entries   A A A A B B A A A B C C C C C C    A was there before
//   changes   0 0 0 0 1 0 1 0 0 1 1 0 0 0 0 0
//   returns               1     1                the others, B and C, take the next index each
//
// Based on: size classes as of a DAG's pointers by use (Kol 2018, 2.4.4; Jaspe 2018, 5.4.3).
// Differs:  changes and returns are one symbol: together they take 0.57 bits per entry of Sponza's baked colours, where bytes
//           of changes with a table per block and a bit per run take 0.75; 8 entries at once take 0.63.
// Bound:    a code is a class of 2 bits and a number as wide as its class says; where it lies is the sum of the widths before,
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

/// As 16 digits: 0, 1 for a change, 2 for a return.
inline constexpr std::uint32_t digit_bits = 26, digit_count = 43046721; ///< 3^16.
[[nodiscard]] std::uint32_t digits_of(Pattern pattern);
/// digits is below digit_count.
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

/// A fourth class has patterns that are in no table, by their digits.
inline constexpr std::uint32_t class_bits = 2, class_count = 3;
/// Patterns by rank, and how many bits a rank has in each class.
struct Table {
    static constexpr std::uint32_t most_width = 15;

    std::array<std::uint32_t, class_count> widths{}; ///< Each up to most_width.
    std::vector<Pattern> patterns;

    [[nodiscard]] std::array<std::uint32_t, class_count> begins() const {
        return {0, 1u << widths[0], (1u << widths[0]) + (1u << widths[1])};
    }
};
/// The one with which codes and the table itself take the fewest bits. counts: of patterns that have changes.
[[nodiscard]] Table best_table(const std::unordered_map<Pattern, std::uint64_t>& counts);

struct Code {
    std::uint32_t of_class, value;
};
class Writer {
public:
    explicit Writer(const Table& table);
    [[nodiscard]] Code code_of(Pattern pattern) const;
    [[nodiscard]] std::uint32_t width(std::uint32_t of_class) const { return widths_[of_class]; }

private:
    std::array<std::uint32_t, class_count + 1> widths_;
    std::array<std::uint32_t, class_count> begins_;
    std::unordered_map<Pattern, std::uint32_t> rank_of_;
};

class Reader {
public:
    Reader() = default;
    explicit Reader(const Table& table);
    [[nodiscard]] std::uint32_t width(std::uint32_t of_class) const { return widths_[of_class]; }
    /// Codes that are not may be asked for, too: they have no change.
    [[nodiscard]] bool is_known(const Code& code) const {
        return code.of_class < class_count ? begins_[code.of_class] + code.value < patterns_.size()
                                           : code.value < digit_count;
    }
    [[nodiscard]] Pattern pattern(const Code& code) const {
        if (!is_known(code))
            return 0;
        return code.of_class < class_count ? patterns_[begins_[code.of_class] + code.value] : pattern_of(code.value);
    }
    /// Indices that a group brings: all that of most codes has to be known.
    [[nodiscard]] std::uint32_t new_count(const Code& code) const {
        if (code.of_class < class_count && is_known(code)) [[likely]]
            return new_counts_[begins_[code.of_class] + code.value];
        return new_count_of(pattern(code));
    }

private:
    [[nodiscard]] static std::uint32_t new_count_of(Pattern pattern) {
        return static_cast<std::uint32_t>(std::popcount(changes_of(pattern)) - std::popcount(returns_of(pattern)));
    }

    std::array<std::uint32_t, class_count + 1> widths_{};
    std::array<std::uint32_t, class_count> begins_{};
    std::vector<Pattern> patterns_;
    std::vector<std::uint8_t> new_counts_; // a byte each, so that they stay in the cache
};
} // namespace tyndall::voxel_dag::run_patterns
