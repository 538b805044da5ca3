// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/run_block.hpp"
#include "voxel_dag/bit_scan.hpp"
#include "voxel_dag/packed_digits.hpp"

namespace tyndall::voxel_dag::run_block {
Reader::Reader(const std::uint8_t* bytes, std::uint64_t begin, std::uint64_t end, const Shape& shape,
               const run_patterns::Reader& patterns)
    : bytes_(bytes), end_(end), patterns_(patterns), cut_off_(find_parts(begin, shape)) {}

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
    const std::uint32_t low_width_bits = bits_for(shape.value_bits + 1);
    const std::uint32_t group_count = 1u << (shape.log2_entries - run_patterns::log2_entries);
    if (!holds(shape.log2_entries + low_width_bits + group_count))
        return "header";
    index_count_ = field(shape.log2_entries) + 1;
    low_bits_ = field(low_width_bits);
    if (low_bits_ > shape.value_bits)
        return "header";
    occupied_ = part(group_count);
    code_count_ = count_ones(bytes_, occupied_, bit);
    if (!holds(std::uint64_t{dictionary_size_} * low_bits_))
        return "dictionary";
    low_ = part(std::uint64_t{dictionary_size_} * low_bits_);
    high_ = bit;
    bit = find_one(bytes_, high_, end_, dictionary_size_ - 1) + 1;
    if (bit > end_)
        return "dictionary";
    if (!holds(packed_digits::bit_count(dictionary_size_, index_count_)))
        return "indices";
    indices_ = part(packed_digits::bit_count(dictionary_size_, index_count_));
    if (!holds(std::uint64_t{code_count_} * run_patterns::class_bits))
        return "codes";
    classes_ = part(std::uint64_t{code_count_} * run_patterns::class_bits);
    codes_ = bit;
    return nullptr;
}

/// Calls visit(code, bit) with the first codes, one after the other, until it returns false.
template <class Visit>
inline void Reader::visit_codes(std::uint32_t count, const Visit& visit) const {
    constexpr std::uint32_t classes_at_once = 64 / run_patterns::class_bits;
    std::uint64_t bit = codes_, classes = 0;
    for (std::uint32_t i = 0; i < count; ++i, classes >>= run_patterns::class_bits) {
        if (i % classes_at_once == 0)
            classes = read_word(bytes_, classes_ + std::uint64_t{i} * run_patterns::class_bits);
        const auto of_class = static_cast<std::uint32_t>(classes & low_bits(run_patterns::class_bits));
        const std::uint32_t width = patterns_.width(of_class);
        if (!visit(run_patterns::Code{of_class, static_cast<std::uint32_t>(read_bits(bytes_, bit, width))}, bit))
            return;
        bit += width;
    }
}

const char* Reader::damage() const {
    if (cut_off_ != nullptr || dictionary_size_ == 1)
        return cut_off_;
    std::uint32_t index_count = 1;
    bool is_whole = true;
    visit_codes(code_count_, [&](const run_patterns::Code& code, std::uint64_t bit) {
        is_whole = bit + patterns_.width(code.of_class) <= end_ && patterns_.is_known(code);
        index_count += patterns_.new_count(code);
        return is_whole;
    });
    return is_whole && index_count == index_count_ ? nullptr : "codes";
}

std::uint32_t Reader::dictionary_value(std::uint32_t index) const {
    const std::uint64_t high = find_one(bytes_, high_, end_, index) - high_ - index;
    const std::uint64_t low = read_bits(bytes_, low_ + std::uint64_t{index} * low_bits_, low_bits_);
    return minimum_ + static_cast<std::uint32_t>(high << low_bits_ | low);
}

std::uint32_t Reader::at(std::uint32_t entry) const {
    if (dictionary_size_ == 1)
        return minimum_;
    const std::uint32_t group = entry / run_patterns::entries;
    const bool is_occupied = read_bits(bytes_, occupied_ + group, 1) != 0;
    std::uint32_t left = count_ones(bytes_, occupied_, occupied_ + group);
    std::array<run_patterns::Code, most_groups> codes;
    std::uint32_t read_count = 0, index_count = 1;
    visit_codes(left + std::uint32_t{is_occupied}, [&](const run_patterns::Code& code, std::uint64_t) {
        index_count += read_count < left ? patterns_.new_count(code) : 0;
        codes[read_count++] = code;
        return true;
    });
    std::uint32_t what = 0; // of the runs before the codes that are left, see Effect
    if (is_occupied)
        what = run_patterns::effect_of(patterns_.pattern(codes[left]), entry % run_patterns::entries).last;
    for (; what < 2 && left > 0; --left) {
        const run_patterns::Effect effect = run_patterns::effect_of(patterns_.pattern(codes[left - 1]));
        index_count -= effect.new_count;
        what = what == 0 ? effect.last : effect.before;
    }
    const std::uint32_t index = what < 2 ? 0 : index_count + what - 2;
    return dictionary_value(packed_digits::read(bytes_, indices_, dictionary_size_, index_count_, index));
}

/// Calls visit(index, value), from the first to the last.
template <class Visit>
inline void Reader::visit_dictionary(const Visit& visit) const {
    for (std::uint32_t index = 0, high = 0; index < dictionary_size_; ++high) {
        std::uint64_t word = read_word(bytes_, high_ + 64 * std::uint64_t{high});
        for (; word != 0 && index < dictionary_size_; word &= word - 1, ++index) {
            const std::uint64_t unary = 64 * high + static_cast<std::uint32_t>(std::countr_zero(word)) - index;
            const std::uint64_t low = read_bits(bytes_, low_ + std::uint64_t{index} * low_bits_, low_bits_);
            visit(index, minimum_ + static_cast<std::uint32_t>(unary << low_bits_ | low));
        }
    }
}

std::uint32_t Reader::largest() const {
    std::uint32_t largest = minimum_; // what was forged may not ascend
    if (dictionary_size_ > 1)
        visit_dictionary([&](std::uint32_t, std::uint32_t value) { largest = std::max(largest, value); });
    return largest;
}

void Reader::decode(std::span<std::uint32_t> values) const {
    if (dictionary_size_ == 1) {
        std::ranges::fill(values, minimum_);
        return;
    }
    std::array<std::uint32_t, packed_digits::most_base> dictionary;
    visit_dictionary([&](std::uint32_t index, std::uint32_t value) { dictionary[index] = value; });
    const packed_digits::Group shape = packed_digits::groups[dictionary_size_];
    std::uint64_t digits = 0;
    std::uint32_t index_number = 0, value = 0, before = 0; // before: the value of the run before
    const auto next_run = [&](bool is_return) {
        std::uint32_t next = before;
        if (!is_return) {
            if (index_number % shape.digit_count == 0)
                digits = packed_digits::read_group(bytes_, indices_, dictionary_size_, index_count_,
                                                   index_number / shape.digit_count);
            next = dictionary[digits % dictionary_size_];
            digits /= dictionary_size_;
            ++index_number;
        }
        before = value, value = next;
    };
    next_run(false);
    before = value; // as at() has it, whatever damaged codes say
    std::size_t entry = 0;
    const auto last_until = [&](std::size_t end) {
        end = std::min(end, values.size());
        if (entry < end)
            std::fill(values.begin() + static_cast<std::ptrdiff_t>(entry),
                      values.begin() + static_cast<std::ptrdiff_t>(end), value);
        entry = std::max(entry, end);
    };
    std::size_t group = 0; // of the next code
    visit_codes(code_count_, [&](const run_patterns::Code& code, std::uint64_t) {
        while (read_bits(bytes_, occupied_ + group, 1) == 0)
            ++group;
        const run_patterns::Pattern pattern = patterns_.pattern(code);
        const std::uint32_t returns = run_patterns::returns_of(pattern);
        for (std::uint32_t left = run_patterns::changes_of(pattern); left != 0; left &= left - 1) {
            const auto in_group = static_cast<std::uint32_t>(std::countr_zero(left));
            last_until(run_patterns::entries * group + in_group);
            next_run((returns >> in_group & 1) != 0);
        }
        ++group;
        return true;
    });
    last_until(values.size());
}
} // namespace tyndall::voxel_dag::run_block
