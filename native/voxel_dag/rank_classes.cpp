// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/rank_classes.hpp"
#include <algorithm>
#include <bit>
#include <vector>

namespace tyndall::voxel_dag {
RankClasses best_classes(std::span<const std::uint32_t> uses, std::uint32_t first_class) {
    std::vector<std::uint64_t> named(uses.size() + 1, 0); // by ranks below
    for (std::size_t rank = 0; rank < uses.size(); ++rank)
        named[rank + 1] = named[rank] + uses[rank];
    const auto most = static_cast<std::uint32_t>(std::bit_width(uses.size()));
    RankClasses best;
    std::uint64_t fewest_bits = ~std::uint64_t{0};
    // The last class takes what the others leave. One that is not needed has width 0 and a rank that nobody has.
    std::array<std::uint32_t, 4> widths{};
    const std::uint32_t free_count = 3 - first_class;
    std::uint64_t combinations = 1;
    for (std::uint32_t i = 0; i < free_count; ++i)
        combinations *= most + 1;
    for (std::uint64_t combination = 0; combination < combinations; ++combination) {
        std::uint64_t digits = combination, bits = 0;
        std::array<std::uint32_t, 4> begins{};
        std::size_t begin = 0;
        for (std::uint32_t i = first_class; i < 4; ++i) {
            widths[i] = static_cast<std::uint32_t>(digits % (most + 1));
            digits /= most + 1;
            if (i == 3) // of the rest
                widths[i] =
                    begin < uses.size() ? static_cast<std::uint32_t>(std::bit_width(uses.size() - begin - 1)) : 0;
            begins[i] = static_cast<std::uint32_t>(std::min(begin, uses.size()));
            const std::size_t end = std::min(uses.size(), begin + (std::size_t{1} << widths[i]));
            bits += widths[i] * (named[end] - named[std::min(begin, uses.size())]);
            begin += std::size_t{1} << widths[i];
        }
        if (bits < fewest_bits) {
            fewest_bits = bits;
            best = {.widths = widths, .begins = begins};
        }
    }
    return best;
}
} // namespace tyndall::voxel_dag
