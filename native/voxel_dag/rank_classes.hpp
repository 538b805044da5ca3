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
} // namespace tyndall::voxel_dag
