// SPDX-License-Identifier: GPL-3.0-or-later
// Values that several owners read and nobody changes: copies share them.
#pragma once
#include <cstddef>
#include <initializer_list>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace tyndall {
template <typename Value>
class SharedArray {
public:
    SharedArray() = default;
    SharedArray(std::vector<Value> values) { // NOLINT(google-explicit-constructor): as a vector is assigned
        auto kept = std::make_shared<const std::vector<Value>>(std::move(values));
        values_ = *kept;
        owner_ = std::move(kept);
    }
    SharedArray(std::initializer_list<Value> values) : SharedArray(std::vector<Value>(values)) {}
    /// Those that `owner` keeps alive.
    SharedArray(std::shared_ptr<const void> owner, std::span<const Value> values)
        : owner_(std::move(owner)), values_(values) {}

    [[nodiscard]] bool empty() const { return values_.empty(); }
    [[nodiscard]] std::size_t size() const { return values_.size(); }
    [[nodiscard]] const Value* data() const { return values_.data(); }
    [[nodiscard]] const Value* begin() const { return values_.data(); }
    [[nodiscard]] const Value* end() const { return values_.data() + values_.size(); }
    const Value& operator[](std::size_t index) const { return values_[index]; }

private:
    std::shared_ptr<const void> owner_;
    std::span<const Value> values_;
};
} // namespace tyndall
