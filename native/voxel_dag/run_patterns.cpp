// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/run_patterns.hpp"
#include <algorithm>
#include <bit>

namespace tyndall::voxel_dag::run_patterns {
std::uint32_t digits_of(Pattern pattern) {
    std::uint32_t digits = 0;
    for (std::uint32_t entry = entries; entry-- > 0;)
        digits = 3 * digits + (changes_of(pattern) >> entry & 1) + (returns_of(pattern) >> entry & 1);
    return digits;
}
Pattern pattern_of(std::uint32_t digits) {
    constexpr std::uint32_t half_count = 6561; // 3^8
    static constexpr auto halves = [] {
        std::array<Pattern, half_count> table{};
        for (std::uint32_t number = 0; number < half_count; ++number)
            for (std::uint32_t entry = 0, left = number; entry < 8; ++entry, left /= 3)
                table[number] |= (left % 3 == 0 ? 0u : left % 3 == 1 ? 1u : 0x10001u) << entry;
        return table;
    }();
    return halves[digits % half_count] | halves[digits / half_count] << 8;
}

Effect effect_of(Pattern pattern, std::uint32_t entry) {
    Effect effect;
    for (std::uint32_t left = pattern & static_cast<std::uint32_t>(low_bits(entry + 1)); left != 0; left &= left - 1)
        effect.change((returns_of(pattern) >> std::countr_zero(left) & 1) != 0);
    return effect;
}

Table best_table(const std::unordered_map<Pattern, std::uint64_t>& counts) {
    struct Counted {
        Pattern pattern;
        std::uint64_t count;
    };
    std::vector<Counted> by_use;
    for (const auto& [pattern, count] : counts)
        by_use.push_back({pattern, count});
    std::ranges::sort(by_use, [](const Counted& a, const Counted& b) {
        return a.count != b.count ? a.count > b.count : a.pattern < b.pattern;
    });
    std::vector<std::uint64_t> uses(by_use.size() + 1); // of the first ones
    for (std::size_t i = 0; i < by_use.size(); ++i)
        uses[i + 1] = uses[i] + by_use[i].count;
    // A pattern in the last class is worth its place where codes become shorter by more than that takes.
    std::array<std::size_t, Table::most_width + 1> worth_size;
    for (std::uint32_t width = 0; width <= Table::most_width; ++width)
        worth_size[width] = static_cast<std::size_t>(std::ranges::count_if(
            by_use, [&](const Counted& counted) { return counted.count * (digit_bits - width) > digit_bits; }));
    Table best;
    std::uint64_t least_bits = uses.back() * digit_bits;
    std::size_t best_size = 0;
    for (std::uint32_t a = 0; a <= Table::most_width; ++a)
        for (std::uint32_t b = a; b <= Table::most_width; ++b)
            for (std::uint32_t c = b; c <= Table::most_width; ++c) {
                const auto up_to = [&](std::size_t rank) { return std::min(rank, by_use.size()); };
                const std::size_t first = std::min(up_to(1u << a), worth_size[c]);
                const std::size_t second = std::min(up_to((1u << a) + (1u << b)), worth_size[c]);
                const std::size_t third = std::min(up_to((1u << a) + (1u << b) + (1u << c)), worth_size[c]);
                const std::uint64_t bits = uses[first] * a + (uses[second] - uses[first]) * b +
                                           (uses[third] - uses[second]) * c + (uses.back() - uses[third]) * digit_bits +
                                           digit_bits * third;
                if (bits < least_bits)
                    least_bits = bits, best.widths = {a, b, c}, best_size = third;
            }
    for (std::size_t i = 0; i < best_size; ++i)
        best.patterns.push_back(by_use[i].pattern);
    return best;
}

static std::array<std::uint32_t, class_count + 1> all_widths(const Table& table) {
    return {table.widths[0], table.widths[1], table.widths[2], digit_bits};
}
Writer::Writer(const Table& table) : widths_(all_widths(table)), begins_(table.begins()) {
    for (std::uint32_t rank = 0; rank < table.patterns.size(); ++rank)
        rank_of_.emplace(table.patterns[rank], rank);
}
Code Writer::code_of(Pattern pattern) const {
    if (const auto known = rank_of_.find(pattern); known != rank_of_.end()) {
        const std::uint32_t rank = known->second, of_class = rank < begins_[1] ? 0 : rank < begins_[2] ? 1 : 2;
        return {of_class, rank - begins_[of_class]};
    }
    return {class_count, digits_of(pattern)};
}

Reader::Reader(const Table& table) : widths_(all_widths(table)), begins_(table.begins()), patterns_(table.patterns) {
    for (const Pattern pattern : patterns_)
        new_counts_.push_back(static_cast<std::uint8_t>(new_count_of(pattern)));
}
} // namespace tyndall::voxel_dag::run_patterns
