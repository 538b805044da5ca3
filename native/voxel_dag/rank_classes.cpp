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

TaggedClasses best_tagged_classes(const TaggedUses& uses) {
    TaggedUses below = uses; // [r][t]: of so many bits at most
    std::uint32_t most_rank = 0, most_tag = 0;
    for (std::uint32_t rank = 0; rank < below.size(); ++rank)
        for (std::uint32_t tag = 0; tag < below[0].size(); ++tag) {
            if (below[rank][tag] != 0)
                most_rank = std::max(most_rank, rank), most_tag = std::max(most_tag, tag);
            if (rank > 0)
                below[rank][tag] += below[rank - 1][tag];
            if (tag > 0)
                below[rank][tag] += below[rank][tag - 1];
            if (rank > 0 && tag > 0)
                below[rank][tag] -= below[rank - 1][tag - 1];
        }
    TaggedClasses best;
    std::uint64_t fewest_bits = ~std::uint64_t{0};
    for (std::uint32_t rank_1 = 0; rank_1 <= most_rank; ++rank_1)
        for (std::uint32_t tag_1 = 0; tag_1 <= most_tag; ++tag_1)
            for (std::uint32_t rank_2 = 0; rank_2 <= most_rank; ++rank_2)
                for (std::uint32_t tag_2 = 0; tag_2 <= most_tag; ++tag_2) {
                    if (rank_1 + tag_1 > rank_2 + tag_2)
                        continue;
                    const std::uint64_t first = below[rank_1][tag_1];
                    const std::uint64_t second =
                        below[rank_2][tag_2] - below[std::min(rank_1, rank_2)][std::min(tag_1, tag_2)];
                    const std::uint64_t third = below[most_rank][most_tag] - first - second;
                    const std::uint64_t bits =
                        first * (rank_1 + tag_1) + second * (rank_2 + tag_2) + third * (most_rank + most_tag);
                    if (bits < fewest_bits) {
                        fewest_bits = bits;
                        best = {.rank_bits = {0, rank_1, rank_2, most_rank}, .tag_bits = {0, tag_1, tag_2, most_tag}};
                    }
                }
    return best;
}
} // namespace tyndall::voxel_dag
