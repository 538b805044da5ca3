// SPDX-License-Identifier: GPL-3.0-or-later
// Ranks in fields of few widths: what is named often has a low rank, and a low rank a short field.
// Based on: Jaspe, dissertation 2018, 5.4.3 (2 widths); Kol, dissertation 2018, 2.4.4 (entropy-coded pointers).
// Differs:  2 bits per child say which width, and the widths are those that make a level's references shortest.
#pragma once
#include <array>
#include <cstdint>
#include <span>

namespace tyndall::voxel_dag {
struct RankClasses {
    std::array<std::uint32_t, 4> widths{}; ///< Bits of a rank, per class.
    std::array<std::uint32_t, 4> begins{}; ///< The first rank of a class; it has 2^width.

    bool operator==(const RankClasses&) const = default;
    /// The class of a rank, none below `first`.
    [[nodiscard]] std::uint32_t class_of(std::uint32_t rank, std::uint32_t first) const {
        std::uint32_t found = first;
        while (found < 3 && rank >= begins[found + 1])
            ++found;
        return found;
    }
};

/// Of ranks that are named so often, `uses` falling. Classes below `first_class` stay empty.
[[nodiscard]] RankClasses best_classes(std::span<const std::uint32_t> uses, std::uint32_t first_class);

/// Ranks that come with the rank of a tag: each class takes the ranks and tags that its widths have room for. Class 0 is
/// none of these.
struct TaggedClasses {
    std::array<std::uint32_t, 4> rank_bits{}, tag_bits{};

    /// The shortest that has room for both.
    [[nodiscard]] std::uint32_t class_of(std::uint32_t rank, std::uint32_t tag_rank) const {
        const auto has_room = [&](std::uint32_t at) {
            return rank >> rank_bits[at] == 0 && tag_rank >> tag_bits[at] == 0;
        };
        return has_room(1) ? 1 : has_room(2) ? 2 : 3;
    }
};
/// uses[r][t]: how often a rank of r bits comes with a tag's rank of t bits.
using TaggedUses = std::array<std::array<std::uint64_t, 7>, 33>;
[[nodiscard]] TaggedClasses best_tagged_classes(const TaggedUses& uses);
} // namespace tyndall::voxel_dag
