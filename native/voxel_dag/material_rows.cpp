// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/material_rows.hpp"
#include "core/errors.hpp"
#include <algorithm>

namespace tyndall::voxel_dag {
static constexpr std::size_t fewest_to_sort = 1 << 16;

void MaterialRows::add(const CountedMaterials& table, const Progress& progress) {
    const std::size_t first = rows_.size();
    rows_.resize(first + table.counts.size(), Row{});
    for (std::size_t i = 0; i < table.counts.size(); ++i) {
        for (std::size_t column = 0; column < column_count_; ++column)
            rows_[first + i].values[column] = table.columns[column][i];
        rows_[first + i].count = table.counts[i];
    }
    if (rows_.size() > std::max(fewest_to_sort, 2 * sorted_count_))
        compact(progress);
}

void MaterialRows::compact(const Progress& progress) {
    progress.poll();
    const auto by_values = [](const Row& a, const Row& b) { return a.values < b.values; };
    std::ranges::sort(rows_, by_values);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
        if (kept > 0 && rows_[kept - 1].values == rows_[i].values)
            rows_[kept - 1].count += rows_[i].count;
        else
            rows_[kept++] = rows_[i];
    }
    rows_.resize(kept);
    sorted_count_ = kept;
    const std::uint64_t bytes = 2 * sizeof(Row) * kept;
    require(bytes <= budget_bytes_ && kept < ~std::uint32_t{0}, "attributes: the table of ", kept,
            " different materials takes about ", bytes >> 20, " MiB, and the budget is ", budget_bytes_ >> 20,
            " MiB: allow more, or choose fewer normal_bits");
}

CountedMaterials MaterialRows::take(const Progress& progress) {
    compact(progress);
    CountedMaterials table{.columns = std::vector<AttributeColumn>(column_count_), .counts = {}};
    table.counts.reserve(rows_.size());
    for (std::size_t column = 0; column < column_count_; ++column) {
        table.columns[column].reserve(rows_.size());
        for (const Row& row : rows_)
            table.columns[column].push_back(row.values[column]);
    }
    for (const Row& row : rows_)
        table.counts.push_back(row.count);
    rows_ = {};
    sorted_count_ = 0;
    return table;
}

std::uint32_t RowFinder::number_of(std::span<const std::uint32_t> row) const {
    std::size_t begin = 0, end = table_.counts.size();
    while (begin < end) {
        const std::size_t middle = begin + (end - begin) / 2;
        std::size_t column = 0;
        while (column + 1 < row.size() && table_.columns[column][middle] == row[column])
            ++column;
        if (table_.columns[column][middle] < row[column])
            begin = middle + 1;
        else
            end = middle;
    }
    return static_cast<std::uint32_t>(begin);
}

std::vector<std::uint32_t> RowFinder::numbers_of(const std::vector<AttributeColumn>& columns) const {
    std::vector<std::uint32_t> numbers(columns.front().size()), row(columns.size());
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        for (std::size_t column = 0; column < row.size(); ++column)
            row[column] = columns[column][i];
        numbers[i] = number_of(row);
    }
    return numbers;
}
} // namespace tyndall::voxel_dag
