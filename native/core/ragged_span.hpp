// SPDX-License-Identifier: GPL-3.0-or-later
// Rows of different lengths in one array (compressed rows); offsets are checked once, in the constructor.
#pragma once
#include "core/errors.hpp"
#include <cstddef>
#include <cstdint>
#include <span>

namespace tyndall {
template <typename Item>
class RaggedSpan {
public:
    /// Row r is items[first[r] .. first[r + 1]). Throws InvalidInput where the offsets do not rise from 0 to the end.
    RaggedSpan(std::span<const std::uint32_t> first, std::span<Item> items) : first_(first), items_(items) {
        require(!first.empty() && first.front() == 0 && first.back() == items.size(),
                "row offsets must start at 0 and end at the number of items, ", items.size());
        for (std::size_t row = 0; row + 1 < first.size(); ++row)
            require(first[row] <= first[row + 1], "row ", row, " ends before it begins");
    }
    [[nodiscard]] std::size_t size() const { return first_.size() - 1; }
    [[nodiscard]] std::span<Item> operator[](std::size_t row) const {
        return items_.subspan(first_[row], first_[row + 1] - first_[row]);
    }

private:
    std::span<const std::uint32_t> first_;
    std::span<Item> items_;
};
} // namespace tyndall
