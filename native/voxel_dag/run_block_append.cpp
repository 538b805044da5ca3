// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/packed_digits.hpp"
#include "voxel_dag/run_block.hpp"

namespace tyndall::voxel_dag::run_block {
namespace {
constexpr std::uint32_t most_counted_bits = 16; // of values: 12 KiB to clear, which takes less than to sort 100

/// The different ones of some values, ascending, and which of them each is.
struct Dictionary {
    std::vector<std::uint32_t> ascending, index_of;
};
Dictionary sorted_dictionary(const std::vector<std::uint32_t>& values) {
    Dictionary dictionary{.ascending = values, .index_of = {}};
    std::ranges::sort(dictionary.ascending);
    dictionary.ascending.erase(std::ranges::unique(dictionary.ascending).begin(), dictionary.ascending.end());
    for (const std::uint32_t value : values)
        dictionary.index_of.push_back(static_cast<std::uint32_t>(std::ranges::lower_bound(dictionary.ascending, value) -
                                                                 dictionary.ascending.begin()));
    return dictionary;
}
/// A bit per possible value and a count per 64 of them: 10 times as fast where there are few.
Dictionary counted_dictionary(const std::vector<std::uint32_t>& values) {
    constexpr std::size_t word_count = (1 << most_counted_bits) / 64;
    std::array<std::uint64_t, word_count> is_there{};
    std::array<std::uint32_t, word_count> below{};
    std::uint32_t first = word_count, last = 0;
    for (const std::uint32_t value : values) {
        is_there[value / 64] |= std::uint64_t{1} << value % 64;
        first = std::min(first, value / 64), last = std::max(last, value / 64);
    }
    Dictionary dictionary;
    for (std::uint32_t word = first; word <= last; ++word) {
        below[word] = static_cast<std::uint32_t>(dictionary.ascending.size());
        for (std::uint64_t left = is_there[word]; left != 0; left &= left - 1)
            dictionary.ascending.push_back(64 * word + static_cast<std::uint32_t>(std::countr_zero(left)));
    }
    for (const std::uint32_t value : values)
        dictionary.index_of.push_back(
            below[value / 64] + static_cast<std::uint32_t>(std::popcount(is_there[value / 64] & low_bits(value % 64))));
    return dictionary;
}

/// Bits of each number that stay as they are, so that all take the fewest.
std::uint32_t cheapest_low_bits(const std::vector<std::uint32_t>& ascending, std::uint32_t value_bits) {
    const std::uint64_t range = ascending.back() - ascending.front();
    const auto cost = [&](std::uint32_t width) { return ascending.size() * width + (range >> width); };
    std::uint32_t best = 0;
    for (std::uint32_t width = 1; width <= value_bits; ++width)
        if (cost(width) < cost(best))
            best = width;
    return best;
}
void append_ascending(const std::vector<std::uint32_t>& ascending, std::uint32_t low_width, BitPacker& bits) {
    for (const std::uint32_t value : ascending)
        bits.append((value - ascending.front()) & low_bits(low_width), low_width);
    std::uint64_t high = 0;
    for (const std::uint32_t value : ascending) {
        const std::uint64_t next = std::uint64_t{value - ascending.front()} >> low_width;
        bits.append_run(0, 1, next - high);
        bits.append(1, 1);
        high = next;
    }
}
} // namespace

Runs runs_of(std::span<const std::uint32_t> values) {
    Runs runs{.groups = std::vector<run_patterns::Pattern>((values.size() + run_patterns::entries - 1) /
                                                           run_patterns::entries),
              .firsts = {values[0]}};
    std::uint32_t last = values[0], before = 0;
    bool has_before = false; // of two runs and more
    for (std::size_t i = 1; i < values.size(); ++i) {
        if (values[i] == last)
            continue;
        const bool is_return = has_before && values[i] == before;
        if (!is_return)
            runs.firsts.push_back(values[i]);
        runs.groups[i / run_patterns::entries] |= (is_return ? (1u << run_patterns::entries) + 1 : 1u)
                                                  << i % run_patterns::entries;
        before = last, last = values[i], has_before = true;
    }
    return runs;
}

void append(std::span<const std::uint32_t> values, const Shape& shape, const run_patterns::Writer& patterns,
            BitPacker& bits) {
    const auto [groups, firsts] = runs_of(values);
    const auto [dictionary, indices] =
        shape.value_bits <= most_counted_bits ? counted_dictionary(firsts) : sorted_dictionary(firsts);
    const auto dictionary_size = static_cast<std::uint32_t>(dictionary.size());
    bits.append(dictionary_size - 1, shape.log2_entries);
    bits.append(dictionary.front(), shape.value_bits);
    if (dictionary_size == 1)
        return;
    const std::uint32_t low_width = cheapest_low_bits(dictionary, shape.value_bits);
    bits.append(indices.size() - 1, shape.log2_entries);
    bits.append(low_width, bits_for(shape.value_bits + 1));
    const std::size_t group_count = std::size_t{1} << (shape.log2_entries - run_patterns::log2_entries);
    for (std::size_t group = 0; group < group_count; ++group)
        bits.append(group < groups.size() && groups[group] != 0, 1);
    append_ascending(dictionary, low_width, bits);
    packed_digits::append(indices, dictionary_size, bits);
    std::vector<run_patterns::Code> codes;
    for (const run_patterns::Pattern pattern : groups)
        if (pattern != 0)
            codes.push_back(patterns.code_of(pattern));
    for (const run_patterns::Code& code : codes)
        bits.append(code.of_class, run_patterns::class_bits);
    for (const run_patterns::Code& code : codes)
        bits.append(code.value, patterns.width(code.of_class));
}
} // namespace tyndall::voxel_dag::run_block
