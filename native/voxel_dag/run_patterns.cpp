// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/run_patterns.hpp"
#include <algorithm>
#include <bit>
#include <functional>
#include <numeric>
#include <span>

namespace tyndall::voxel_dag::run_patterns {
namespace {
/// By digits, in the lower eight bits of both halves of a pattern.
constexpr auto pattern_of_half = [] {
    std::array<Pattern, half_count> table{};
    for (std::uint32_t digits = 0; digits < half_count; ++digits)
        for (std::uint32_t entry = 0, left = digits; entry < half_entries; ++entry, left /= 3)
            table[digits] |= (left % 3 == 0 ? 0u : left % 3 == 1 ? 1u : 0x10001u) << entry;
    return table;
}();
std::uint8_t new_count_of(Pattern pattern) {
    return static_cast<std::uint8_t>(std::popcount(changes_of(pattern)) - std::popcount(returns_of(pattern)));
}
constexpr std::uint32_t digits_of_half(Pattern pattern, std::uint32_t half) {
    std::uint32_t digits = 0;
    for (std::uint32_t entry = (half + 1) * half_entries; entry-- > half * half_entries;)
        digits = 3 * digits + (changes_of(pattern) >> entry & 1) + (returns_of(pattern) >> entry & 1);
    return digits;
}
} // namespace

std::uint32_t digits_of(Pattern pattern) {
    return digits_of_half(pattern, 0) | digits_of_half(pattern, 1) << half_bits;
}
Pattern pattern_of(std::uint32_t digits) {
    return pattern_of_half[digits & low_bits(half_bits)] | pattern_of_half[digits >> half_bits] << half_entries;
}

Effect effect_of(Pattern pattern, std::uint32_t entry) {
    Effect effect;
    for (std::uint32_t left = pattern & static_cast<std::uint32_t>(low_bits(entry + 1)); left != 0; left &= left - 1)
        effect.change((returns_of(pattern) >> std::countr_zero(left) & 1) != 0);
    return effect;
}

namespace {
struct Counted {
    Pattern pattern;
    std::uint64_t count;
};

/// Which of patterns, by falling use, get ranks, and how wide these are, where another takes `other_bits`.
void choose_patterns(std::span<const Counted> by_use, std::uint32_t other_bits, Table& table) {
    constexpr std::uint32_t most = Table::most_width;
    std::vector<std::uint64_t> uses(by_use.size() + 1); // of the first ones
    for (std::size_t i = 0; i < by_use.size(); ++i)
        uses[i + 1] = uses[i] + by_use[i].count;
    // A pattern in the last class is worth its place where codes become shorter by more than that takes.
    std::array<std::size_t, most + 1> worth_size{};
    for (std::uint32_t width = 0; width <= std::min(most, other_bits); ++width)
        worth_size[width] = static_cast<std::size_t>(std::ranges::count_if(
            by_use, [&](const Counted& counted) { return counted.count * (other_bits - width) > digit_bits; }));
    std::uint64_t least_bits = uses.back() * other_bits;
    std::size_t best_size = 0;
    table.widths = {};
    for (std::uint32_t a = 0; a <= most; ++a)
        for (std::uint32_t b = a; b <= most; ++b)
            for (std::uint32_t c = b; c <= most; ++c)
                for (std::uint32_t d = c; d <= most; ++d) {
                    std::uint64_t bits = 0;
                    std::size_t end = 0, rank_count = 0;
                    for (const std::uint32_t width : {a, b, c, d}) {
                        const std::size_t begin = end;
                        rank_count += std::size_t{1} << width;
                        end = std::min(rank_count, worth_size[d]);
                        bits += (uses[end] - uses[begin]) * width;
                    }
                    bits += (uses.back() - uses[end]) * other_bits + digit_bits * end;
                    if (bits < least_bits)
                        least_bits = bits, table.widths = {a, b, c, d}, best_size = end;
                }
    table.patterns.clear();
    for (std::size_t i = 0; i < best_size; ++i)
        table.patterns.push_back(by_use[i].pattern);
}

/// Which halves of patterns without a rank get one. Returns the bits of such a pattern in the mean, rounded up.
std::uint32_t choose_halves(std::span<const Counted> others, Table& table) {
    std::vector<std::uint64_t> uses(half_count);
    std::uint64_t use_count = 0;
    for (const auto& [pattern, count] : others) {
        uses[digits_of_half(pattern, 0)] += count, uses[digits_of_half(pattern, 1)] += count;
        use_count += count;
    }
    std::vector<std::uint32_t> by_use(half_count);
    std::iota(by_use.begin(), by_use.end(), 0u);
    std::ranges::stable_sort(by_use, std::greater(), [&](std::uint32_t half) { return uses[half]; });
    const auto used = static_cast<std::size_t>(std::ranges::count_if(uses, [](std::uint64_t of) { return of > 0; }));
    std::uint64_t least_bits = ~std::uint64_t{0}, narrow_uses = 0;
    for (std::uint32_t width = 0, rank = 0; width < half_bits; ++width) {
        for (; rank < std::min<std::size_t>(std::size_t{1} << width, used); ++rank)
            narrow_uses += uses[by_use[rank]];
        const std::uint64_t bits =
            narrow_uses * width + (2 * use_count - narrow_uses) * half_bits + std::uint64_t{half_bits} * rank;
        if (bits < least_bits)
            least_bits = bits, table.narrow_width = width, table.halves.assign(by_use.begin(), by_use.begin() + rank);
    }
    return use_count == 0 ? digit_bits : static_cast<std::uint32_t>((least_bits + use_count - 1) / use_count);
}
} // namespace

Table best_table(const std::unordered_map<Pattern, std::uint64_t>& counts) {
    std::vector<Counted> by_use;
    for (const auto& [pattern, count] : counts)
        by_use.push_back({pattern, count});
    std::ranges::sort(by_use, [](const Counted& a, const Counted& b) {
        return a.count != b.count ? a.count > b.count : a.pattern < b.pattern;
    });
    Table table;
    std::uint32_t other_bits = digit_bits;
    for (int round = 0; round < 2; ++round) { // as what has no rank takes less, fewer are worth one
        choose_patterns(by_use, other_bits, table);
        other_bits = std::min(digit_bits, choose_halves(std::span(by_use).subspan(table.patterns.size()), table));
    }
    return table;
}

Widths::Widths(const Table& table) : begins_(table.begins()), narrow_width_(table.narrow_width) {
    for (std::uint32_t of_class = 0; of_class < class_count; ++of_class)
        widths_[of_class] =
            of_class < ranked_count ? table.widths[of_class] : half_width(of_class, 0) + half_width(of_class, 1);
}

Writer::Writer(const Table& table) : Widths(table), rank_of_half_(half_count, half_count) {
    for (std::uint32_t rank = 0; rank < table.patterns.size(); ++rank)
        rank_of_.emplace(table.patterns[rank], rank);
    for (std::uint32_t rank = 0; rank < table.halves.size(); ++rank)
        rank_of_half_[table.halves[rank]] = rank;
}
Code Writer::code_of(Pattern pattern) const {
    if (const auto known = rank_of_.find(pattern); known != rank_of_.end()) {
        std::uint32_t of_class = 0;
        while (known->second >= begins_[of_class + 1])
            ++of_class;
        return {of_class, known->second - begins_[of_class]};
    }
    Code code{ranked_count, 0};
    for (const std::uint32_t half : {1u, 0u}) {
        const std::uint32_t digits = digits_of_half(pattern, half), rank = rank_of_half_[digits];
        const bool has_rank = rank < half_count;
        code.of_class += has_rank ? 0 : 1u << half;
        code.value = code.value << (has_rank ? narrow_width_ : half_bits) | (has_rank ? rank : digits);
    }
    return code;
}

Reader::Reader(const Table& table) : Widths(table), patterns_(table.patterns), halves_(table.halves) {
    halves_.resize(std::size_t{1} << narrow_width_, half_count);
    const std::uint32_t narrow = begins_.back(), wide = narrow + (1u << narrow_width_), none = wide + (1u << half_bits);
    new_counts_.resize(none + 1); // nothing where there is no such code
    for (std::size_t rank = 0; rank < patterns_.size(); ++rank)
        new_counts_[rank] = new_count_of(patterns_[rank]);
    for (std::size_t rank = 0; rank < table.halves.size(); ++rank)
        new_counts_[narrow + rank] = new_count_of(pattern_of_half[table.halves[rank]]);
    for (std::size_t digits = 0; digits < half_count; ++digits)
        new_counts_[wide + digits] = new_count_of(pattern_of_half[digits]);
    for (std::uint32_t of_class = 0; of_class < ranked_count; ++of_class)
        parts_[of_class] = {begins_[of_class], widths_[of_class], none};
    for (std::uint32_t of_class = ranked_count; of_class < class_count; ++of_class)
        parts_[of_class] = {.first = is_wide(of_class, 0) ? wide : narrow,
                            .first_width = half_width(of_class, 0),
                            .second = is_wide(of_class, 1) ? wide : narrow};
}
} // namespace tyndall::voxel_dag::run_patterns
