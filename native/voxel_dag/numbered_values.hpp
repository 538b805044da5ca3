// SPDX-License-Identifier: GPL-3.0-or-later
// Different values get numbers 0, 1, 2, ... in the order in which they first come.
// Bound:    open addressing, at most half full: 8 to 16 bytes per different value and the values themselves.
#pragma once
#include "core/random.hpp"
#include <algorithm>
#include <vector>

namespace tyndall::voxel_dag {
template <typename Value>
class NumberedValues {
public:
    std::uint32_t number_of(const Value& value) {
        std::size_t slot = first_slot(value);
        for (; slots_[slot] != 0; slot = (slot + 1) & (slots_.size() - 1))
            if (values_[slots_[slot] - 1] == value)
                return slots_[slot] - 1;
        values_.push_back(value);
        slots_[slot] = static_cast<std::uint32_t>(values_.size());
        if (2 * values_.size() > slots_.size())
            grow();
        return static_cast<std::uint32_t>(values_.size() - 1);
    }
    /// By number.
    [[nodiscard]] const std::vector<Value>& values() const { return values_; }

private:
    std::size_t first_slot(std::uint64_t value) const {
        return hash(static_cast<std::uint32_t>(value), static_cast<std::uint32_t>(value >> 32)) & (slots_.size() - 1);
    }
    void grow() {
        slots_.assign(2 * slots_.size(), 0);
        for (std::size_t i = 0; i < values_.size(); ++i) {
            std::size_t slot = first_slot(values_[i]);
            while (slots_[slot] != 0)
                slot = (slot + 1) & (slots_.size() - 1);
            slots_[slot] = static_cast<std::uint32_t>(i + 1);
        }
    }
    std::vector<Value> values_;
    std::vector<std::uint32_t> slots_ = std::vector<std::uint32_t>(1024); // 1 + a number; 0: free
};

/// Numbers of values in ascending order, by their numbers so far.
template <typename Value>
struct AscendingOrder {
    std::vector<Value> values;
    std::vector<std::uint32_t> rank;
    explicit AscendingOrder(const std::vector<Value>& numbered) : values(numbered), rank(numbered.size()) {
        std::ranges::sort(values);
        for (std::size_t number = 0; number < rank.size(); ++number)
            rank[number] =
                static_cast<std::uint32_t>(std::ranges::lower_bound(values, numbered[number]) - values.begin());
    }
};
} // namespace tyndall::voxel_dag
