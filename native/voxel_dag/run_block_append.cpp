// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/packed_digits.hpp"
#include "voxel_dag/run_block.hpp"

namespace tyndall::voxel_dag::run_block {
namespace {
constexpr std::uint32_t most_counted_bits = 16; // of values: 12 KiB to clear, which takes less than to sort 100

/// Set where an entry differs from the one before it.
struct Flags {
    std::vector<std::uint8_t> bytes; // of 8 entries
    std::vector<std::uint32_t> runs; // their values
};
Flags flags_of(std::span<const std::uint32_t> values, std::uint32_t log2_entries) {
    Flags flags{.bytes = std::vector<std::uint8_t>(std::size_t{1} << (log2_entries - 3)),
                .runs = std::vector<std::uint32_t>(values.size() + 1)};
    std::size_t run_count = 0;
    std::uint32_t before = ~values[0];
    for (std::size_t i = 0; i < values.size(); ++i) { // no branch: every value is written, few are kept
        const bool is_new = values[i] != before;
        before = flags.runs[run_count] = values[i];
        run_count += is_new;
        flags.bytes[i / 8] = static_cast<std::uint8_t>(flags.bytes[i / 8] | std::uint32_t{is_new} << i % 8);
    }
    flags.bytes[0] &= 0xfe; // the first run begins anyway
    flags.runs.resize(run_count);
    return flags;
}

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

/// The different bytes, if they and indices of them are shorter than the bytes.
struct ByteTable {
    std::uint32_t width = 8;
    std::vector<std::uint8_t> bytes = {};
};
ByteTable table_of(std::vector<std::uint8_t> bytes) {
    const std::size_t count = bytes.size();
    std::ranges::sort(bytes);
    bytes.erase(std::ranges::unique(bytes).begin(), bytes.end());
    const std::uint32_t width = bits_for(bytes.size());
    if (count * width + 8 * bytes.size() + 8 >= 8 * count)
        return {};
    return {width, std::move(bytes)};
}

void append_flags(const std::vector<std::uint8_t>& flags, const ByteTable& table, BitPacker& bits) {
    for (std::size_t group = 0; group < flags.size(); group += 8)
        bits.append(std::any_of(&flags[group], &flags[group] + 8, [](std::uint8_t byte) { return byte != 0; }), 1);
    for (std::size_t group = 0; group < flags.size(); group += 8) {
        std::uint32_t occupied = 0;
        for (std::size_t i = 0; i < 8; ++i)
            occupied |= std::uint32_t{flags[group + i] != 0} << i;
        bits.append(occupied, occupied == 0 ? 0 : 8);
    }
    if (table.width < 8)
        bits.append(table.bytes.size() - 1, 8);
    for (const std::uint8_t byte : table.bytes)
        bits.append(byte, 8);
    for (const std::uint8_t byte : flags)
        if (byte != 0)
            bits.append(table.width == 8 ? byte
                                         : static_cast<std::uint64_t>(std::ranges::lower_bound(table.bytes, byte) -
                                                                      table.bytes.begin()),
                        table.width);
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

void append(std::span<const std::uint32_t> values, const Shape& shape, BitPacker& bits) {
    const auto [flags, runs] = flags_of(values, shape.log2_entries);
    const auto repeats = [&runs = runs](std::size_t run) { return run >= 2 && runs[run] == runs[run - 2]; };
    std::vector<std::uint32_t> firsts; // values that do not repeat the one before last
    for (std::size_t run = 0; run < runs.size(); ++run)
        if (!repeats(run))
            firsts.push_back(runs[run]);
    const auto [dictionary, indices] =
        shape.value_bits <= most_counted_bits ? counted_dictionary(firsts) : sorted_dictionary(firsts);
    const auto dictionary_size = static_cast<std::uint32_t>(dictionary.size());
    bits.append(dictionary_size - 1, shape.log2_entries);
    bits.append(dictionary.front(), shape.value_bits);
    if (dictionary_size == 1)
        return;
    std::vector<std::uint8_t> occupied;
    std::ranges::copy_if(flags, std::back_inserter(occupied), [](std::uint8_t byte) { return byte != 0; });
    const ByteTable table = table_of(std::move(occupied));
    const std::uint32_t low_width = cheapest_low_bits(dictionary, shape.value_bits);
    bits.append(runs.size() - 1, shape.log2_entries);
    bits.append(low_width, bits_for(shape.value_bits + 1));
    bits.append(table.width, 4);
    append_flags(flags, table, bits);
    for (std::size_t run = 2; run < runs.size(); ++run)
        bits.append(repeats(run), 1);
    append_ascending(dictionary, low_width, bits);
    packed_digits::append(indices, dictionary_size, bits);
}
} // namespace tyndall::voxel_dag::run_block
