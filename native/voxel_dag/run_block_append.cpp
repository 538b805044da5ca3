// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/packed_digits.hpp"
#include "voxel_dag/run_block.hpp"

namespace tyndall::voxel_dag::run_block {
namespace {
/// Set where an entry differs from the one before it.
struct Flags {
    std::vector<std::uint8_t> bytes; // of 8 entries
    std::vector<std::uint32_t> runs; // their values
};
Flags flags_of(std::span<const std::uint32_t> values, std::uint32_t log2_entries) {
    Flags flags{.bytes = std::vector<std::uint8_t>(std::size_t{1} << (log2_entries - 3)), .runs = {values[0]}};
    for (std::size_t i = 1; i < values.size(); ++i)
        if (values[i] != values[i - 1]) {
            flags.bytes[i / 8] = static_cast<std::uint8_t>(flags.bytes[i / 8] | 1u << i % 8);
            flags.runs.push_back(values[i]);
        }
    return flags;
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

void append_flags(const std::vector<std::uint8_t>& flags, const ByteTable& table, BitWriter& bits) {
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
void append_ascending(const std::vector<std::uint32_t>& ascending, std::uint32_t low_width, BitWriter& bits) {
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

void append(std::span<const std::uint32_t> values, const Shape& shape, BitWriter& bits) {
    const auto [flags, runs] = flags_of(values, shape.log2_entries);
    const auto repeats = [&runs = runs](std::size_t run) { return run >= 2 && runs[run] == runs[run - 2]; };
    std::vector<std::uint32_t> indices, dictionary;
    for (std::size_t run = 0; run < runs.size(); ++run)
        if (!repeats(run))
            indices.push_back(runs[run]);
    dictionary = indices;
    std::ranges::sort(dictionary);
    dictionary.erase(std::ranges::unique(dictionary).begin(), dictionary.end());
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
    for (std::uint32_t& index : indices)
        index = static_cast<std::uint32_t>(std::ranges::lower_bound(dictionary, index) - dictionary.begin());
    packed_digits::append(indices, dictionary_size, bits);
}
} // namespace tyndall::voxel_dag::run_block
