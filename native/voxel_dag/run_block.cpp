// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/run_block.hpp"
#include "voxel_dag/bit_scan.hpp"
#include "voxel_dag/packed_digits.hpp"

namespace tyndall::voxel_dag::run_block {
static constexpr std::uint32_t byte_width_bits = 4; // holds [0, 8]; 8: the bytes themselves, no table
static constexpr std::uint64_t even_bits = 0x5555555555555555u;

Reader::Reader(const std::uint8_t* bytes, std::uint64_t begin, std::uint64_t end, const Shape& shape)
    : bytes_(bytes), end_(end), cut_off_(find_parts(begin, shape)) {}

const char* Reader::find_parts(std::uint64_t begin, const Shape& shape) {
    std::uint64_t bit = begin;
    const auto holds = [&](std::uint64_t width) { return bit <= end_ && width <= end_ - bit; };
    const auto field = [&](std::uint32_t width) {
        const std::uint64_t value = read_bits(bytes_, bit, width);
        bit += width;
        return static_cast<std::uint32_t>(value);
    };
    const auto part = [&](std::uint64_t width) {
        const std::uint64_t at = bit;
        bit += width;
        return at;
    };
    if (!holds(shape.log2_entries + shape.value_bits))
        return "first value";
    dictionary_size_ = field(shape.log2_entries) + 1;
    minimum_ = field(shape.value_bits);
    if (dictionary_size_ == 1)
        return nullptr;
    const std::uint32_t low_width_bits = bits_for(shape.value_bits + 1), group_count = 1u << (shape.log2_entries - 6);
    if (!holds(shape.log2_entries + low_width_bits + byte_width_bits + group_count))
        return "header";
    run_count_ = field(shape.log2_entries) + 1;
    low_bits_ = field(low_width_bits);
    byte_bits_ = field(byte_width_bits);
    if (low_bits_ > shape.value_bits || byte_bits_ > 8)
        return "header";
    occupied_64_ = read_word(bytes_, part(group_count)) & low_bits(group_count);
    const std::uint64_t occupied_8_width = 8 * static_cast<std::uint64_t>(std::popcount(occupied_64_));
    if (!holds(occupied_8_width))
        return "groups of 8";
    occupied_8_ = part(occupied_8_width);
    byte_count_ = count_ones(bytes_, occupied_8_, bit);
    if (byte_bits_ < 8) {
        if (!holds(8))
            return "table of bytes";
        table_size_ = field(8) + 1;
        if (!holds(8 * table_size_))
            return "table of bytes";
        byte_table_ = part(8 * table_size_);
    }
    const std::uint64_t repeat_count = run_count_ < 2 ? 0 : run_count_ - 2;
    if (!holds(byte_count_ * byte_bits_ + repeat_count + dictionary_size_ * low_bits_))
        return "runs";
    bytes_at_ = part(byte_count_ * byte_bits_);
    repeats_ = part(repeat_count);
    index_count_ = run_count_ - count_ones(bytes_, repeats_, repeats_ + repeat_count);
    low_ = part(dictionary_size_ * low_bits_);
    high_ = bit;
    bit = find_one(bytes_, high_, end_, dictionary_size_ - 1) + 1;
    if (bit > end_)
        return "dictionary";
    if (!holds(packed_digits::bit_count(dictionary_size_, index_count_)))
        return "indices";
    indices_ = bit;
    return nullptr;
}

const char* Reader::damage() const {
    if (cut_off_ != nullptr || dictionary_size_ == 1)
        return cut_off_;
    return runs_before(byte_count_) + 1 == run_count_ ? nullptr : "flags";
}

inline std::uint8_t Reader::byte_of_table(std::uint64_t index) const {
    const std::uint64_t within = std::min<std::uint64_t>(index, table_size_ - 1); // beyond it only if it is damaged
    return static_cast<std::uint8_t>(read_bits(bytes_, byte_table_ + 8 * within, 8));
}
std::uint8_t Reader::flag_byte(std::uint32_t number) const {
    const std::uint64_t stored = read_bits(bytes_, bytes_at_ + std::uint64_t{number} * byte_bits_, byte_bits_);
    if (byte_bits_ == 8)
        return static_cast<std::uint8_t>(stored);
    return byte_of_table(stored);
}

/// Flags that are set in the first bytes.
std::uint32_t Reader::runs_before(std::uint32_t byte_count) const {
    if (byte_bits_ == 8)
        return count_ones(bytes_, bytes_at_, bytes_at_ + 8 * std::uint64_t{byte_count});
    if (byte_bits_ == 0)
        return byte_count * static_cast<std::uint32_t>(std::popcount(flag_byte(0)));
    const std::uint32_t together = most_packed_bits / byte_bits_; // indices in a word
    int count = 0;
    for (std::uint32_t begin = 0; begin < byte_count; begin += together) {
        std::uint64_t word = read_bits(bytes_, bytes_at_ + std::uint64_t{begin} * byte_bits_, most_packed_bits);
        for (std::uint32_t left = std::min(together, byte_count - begin); left > 0; --left, word >>= byte_bits_)
            count += std::popcount(byte_of_table(word & low_bits(byte_bits_)));
    }
    return static_cast<std::uint32_t>(count);
}

std::uint32_t Reader::run_of(std::uint32_t entry) const {
    const std::uint32_t group = entry / 64, in_group = entry / 8 % 8;
    const auto before = static_cast<std::uint32_t>(std::popcount(occupied_64_ & low_bits(group)));
    if ((occupied_64_ >> group & 1) == 0)
        return runs_before(count_ones(bytes_, occupied_8_, occupied_8_ + 8 * before));
    const std::uint64_t here = occupied_8_ + 8 * before + in_group;
    const std::uint32_t byte = count_ones(bytes_, occupied_8_, here);
    const std::uint32_t run = runs_before(byte);
    if (read_bits(bytes_, here, 1) == 0)
        return run;
    return run + static_cast<std::uint32_t>(std::popcount(flag_byte(byte) & low_bits(entry % 8 + 1)));
}

/// The run that a run's value is from: back by two while it repeats the value before last.
std::uint32_t Reader::origin_of(std::uint32_t run) const {
    while (run >= 2) {
        // Bit 0 is run - 2's flag where there are 63 before it: what counts then is bits 62, 60, ...
        const std::uint32_t flag = run - 2, window = std::min(flag, 62u);
        const std::uint64_t flags = read_word(bytes_, repeats_ + flag - window) << (63 - window);
        const std::uint64_t breaks = ~flags & (even_bits << 1); // bit 63 is the flag of `run`, 61 that of run - 2
        const auto steps = static_cast<std::uint32_t>(std::countl_zero(breaks)) / 2;
        const std::uint32_t in_window = window / 2 + 1;
        if (steps < in_window)
            return run - 2 * steps;
        run -= 2 * in_window;
    }
    return run;
}

std::uint32_t Reader::dictionary_value(std::uint32_t index) const {
    const std::uint64_t high = find_one(bytes_, high_, end_, index) - high_ - index;
    const std::uint64_t low = read_bits(bytes_, low_ + std::uint64_t{index} * low_bits_, low_bits_);
    return minimum_ + static_cast<std::uint32_t>(high << low_bits_ | low);
}

std::uint32_t Reader::at(std::uint32_t entry) const {
    if (dictionary_size_ == 1)
        return minimum_;
    const std::uint32_t run = origin_of(run_of(entry));
    const std::uint32_t index_number = run < 2 ? run : run - count_ones(bytes_, repeats_, repeats_ + run - 2);
    return dictionary_value(packed_digits::read(bytes_, indices_, dictionary_size_, index_count_, index_number));
}

void Reader::decode(std::span<std::uint32_t> values) const {
    if (dictionary_size_ == 1) {
        std::ranges::fill(values, minimum_);
        return;
    }
    std::array<std::uint32_t, packed_digits::most_base> dictionary;
    for (std::uint32_t index = 0, high = 0; index < dictionary_size_; ++high) {
        std::uint64_t word = read_word(bytes_, high_ + 64 * std::uint64_t{high});
        for (; word != 0 && index < dictionary_size_; word &= word - 1, ++index) {
            const std::uint64_t unary = 64 * high + static_cast<std::uint32_t>(std::countr_zero(word)) - index;
            const std::uint64_t low = read_bits(bytes_, low_ + std::uint64_t{index} * low_bits_, low_bits_);
            dictionary[index] = minimum_ + static_cast<std::uint32_t>(unary << low_bits_ | low);
        }
    }
    const packed_digits::Group shape = packed_digits::groups[dictionary_size_];
    std::uint64_t digits = 0;
    std::uint32_t index_number = 0, run = 0, value = 0, before = 0; // before: the value of the run before
    const auto next_run = [&] {
        const bool is_repeat = run >= 2 && read_bits(bytes_, repeats_ + run - 2, 1) != 0;
        std::uint32_t next = before;
        if (!is_repeat) {
            if (index_number % shape.digit_count == 0)
                digits = packed_digits::read_group(bytes_, indices_, dictionary_size_, index_count_,
                                                   index_number / shape.digit_count);
            next = dictionary[digits % dictionary_size_];
            digits /= dictionary_size_;
            ++index_number;
        }
        before = value, value = next, ++run;
    };
    next_run();
    std::size_t entry = 0;
    std::uint32_t byte = 0;
    std::uint64_t group_8 = occupied_8_;
    const auto last_until = [&](std::size_t end) {
        end = std::min(end, values.size());
        if (entry < end)
            std::fill(values.begin() + static_cast<std::ptrdiff_t>(entry),
                      values.begin() + static_cast<std::ptrdiff_t>(end), value);
        entry = std::max(entry, end);
    };
    for (std::uint64_t groups = occupied_64_; groups != 0; groups &= groups - 1, group_8 += 8)
        for (std::uint64_t eights = read_bits(bytes_, group_8, 8); eights != 0; eights &= eights - 1) {
            const auto first = static_cast<std::size_t>(64 * std::countr_zero(groups) + 8 * std::countr_zero(eights));
            for (std::uint32_t flags = flag_byte(byte++); flags != 0; flags &= flags - 1) {
                last_until(first + static_cast<std::size_t>(std::countr_zero(flags)));
                next_run();
            }
        }
    last_until(values.size());
}
} // namespace tyndall::voxel_dag::run_block
