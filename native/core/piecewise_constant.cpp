// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/piecewise_constant.hpp"
#include <algorithm>

namespace tyndall {
PiecewiseConstant1d::PiecewiseConstant1d(std::span<const float> weights) : sums_(weights.size() + 1) {
    double total = 0.0;
    for (const float weight : weights)
        total += weight;
    const double cell_count = static_cast<double>(weights.size());
    double sum = 0.0;
    for (std::size_t cell = 0; cell < weights.size(); ++cell) {
        sum += total > 0.0 ? weights[cell] / total : 1.0 / cell_count;
        sums_[cell + 1] = static_cast<float>(std::min(sum, 1.0));
    }
    // The last cell with a weight ends at 1, so that no u < 1 falls behind it into a cell without one.
    const float rounded_total = sums_.back();
    for (std::size_t sum_index = sums_.size(); sum_index-- > 1 && sums_[sum_index] == rounded_total;)
        sums_[sum_index] = 1.0f;
}

PiecewiseConstant1d::Sample PiecewiseConstant1d::sample(float u) const {
    // The last sum that is not above u begins the cell; cells without a weight are skipped, being empty.
    const auto after = std::upper_bound(sums_.begin() + 1, sums_.end() - 1, u);
    const auto cell = static_cast<std::uint32_t>(after - sums_.begin() - 1);
    const float width = probability(cell);
    const float offset = width > 0.0f ? (u - sums_[cell]) / width : 0.0f;
    return {cell, std::clamp(offset, 0.0f, 0x1.fffffep-1f)};
}

PiecewiseConstant2d::Sample PiecewiseConstant2d::sample(vec2 u) const {
    const auto [row, row_offset] = rows_.sample(u.y);
    const auto [column, column_offset] = columns_of_row_[row].sample(u.x);
    return {column, row, {column_offset, row_offset}};
}
} // namespace tyndall
