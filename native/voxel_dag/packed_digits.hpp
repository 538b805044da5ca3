// SPDX-License-Identifier: GPL-3.0-or-later
// Digits of any base, as many in one number as waste the fewest bits: 4 of base 38 in 21 bits, 5.25 each instead of 6.
// Bound:    two divisions per digit; 0.01 to 0.1 bits beyond log2(base), which saves 6 % of the indices of a scan's normals.
#pragma once
#include "voxel_dag/bit_packing.hpp"
#include <algorithm>
#include <array>

namespace tyndall::voxel_dag::packed_digits {
inline constexpr std::uint32_t most_base = 4096;

struct Group {
    std::uint32_t digit_count, bits;
};
/// Of the group sizes that fit one read, the first with the fewest bits per digit.
[[nodiscard]] constexpr Group best_group(std::uint64_t base) {
    Group best{1, bits_for(base)};
    std::uint64_t power = base;
    for (std::uint32_t digits = 2; base > 1 && power <= low_bits(most_packed_bits) / base; ++digits) {
        power *= base;
        if (const std::uint32_t bits = bits_for(power); bits * best.digit_count < best.bits * digits)
            best = {digits, bits};
    }
    return best;
}
inline constexpr auto groups = [] {
    std::array<Group, most_base + 1> of_base{};
    for (std::uint32_t base = 1; base <= most_base; ++base)
        of_base[base] = best_group(base);
    return of_base;
}();

[[nodiscard]] constexpr std::uint64_t power(std::uint64_t base, std::uint32_t exponent) {
    std::uint64_t value = 1;
    for (; exponent > 0; --exponent)
        value *= base;
    return value;
}
/// Of `count` digits of `base`, [1, most_base]; the last group has the rest.
[[nodiscard]] inline std::uint64_t bit_count(std::uint32_t base, std::uint32_t count) {
    const Group group = groups[base];
    return std::uint64_t{count / group.digit_count} * group.bits + bits_for(power(base, count % group.digit_count));
}
inline void append(std::span<const std::uint32_t> digits, std::uint32_t base, BitPacker& bits) {
    const Group group = groups[base];
    for (std::size_t begin = 0; begin < digits.size(); begin += group.digit_count) {
        const auto part = digits.subspan(begin, std::min<std::size_t>(group.digit_count, digits.size() - begin));
        std::uint64_t number = 0;
        for (std::size_t i = part.size(); i-- > 0;)
            number = number * base + part[i];
        bits.append(number, bits_for(power(base, static_cast<std::uint32_t>(part.size()))));
    }
}
/// All digits of group number `group`, lowest first.
[[nodiscard]] inline std::uint64_t read_group(const std::uint8_t* bytes, std::uint64_t position, std::uint32_t base,
                                              std::uint32_t count, std::uint32_t group) {
    const Group shape = groups[base];
    const std::uint32_t rest = count - group * shape.digit_count;
    const std::uint32_t width = rest < shape.digit_count ? bits_for(power(base, rest)) : shape.bits;
    return read_bits(bytes, position + std::uint64_t{group} * shape.bits, width);
}
/// Digit number `index` of `count`. Below base, whatever the bits are.
[[nodiscard]] inline std::uint32_t read(const std::uint8_t* bytes, std::uint64_t position, std::uint32_t base,
                                        std::uint32_t count, std::uint32_t index) {
    const Group shape = groups[base];
    const std::uint64_t number = read_group(bytes, position, base, count, index / shape.digit_count);
    return static_cast<std::uint32_t>(number / power(base, index % shape.digit_count) % base);
}
} // namespace tyndall::voxel_dag::packed_digits
