// SPDX-License-Identifier: GPL-3.0-or-later
// Tables of materials as one, without those that come twice: what parts have together.
// Differs:  rows are added at the end, and sorted when they are as many as the sorted ones: whatever the number of tables,
//           every row is sorted a few times.
// Bound:    32 bytes per row, twice the different ones and those of the largest table at most.
#pragma once
#include "voxel_dag/given_materials.hpp"

namespace tyndall::voxel_dag {
class MaterialRows {
public:
    /// Of rows of so many values.
    MaterialRows(std::size_t column_count, std::uint64_t memory_budget_bytes)
        : column_count_(column_count), budget_bytes_(memory_budget_bytes) {}
    /// Throws InvalidInput where the budget does not suffice, and Cancelled.
    void add(const CountedMaterials& table, const Progress& progress);
    /// Those that are there, in the order of their values.
    [[nodiscard]] CountedMaterials take(const Progress& progress);

private:
    static constexpr std::size_t most_columns = 2 + VoxelAttributes::most_channels;
    struct Row {
        std::array<std::uint32_t, most_columns> values;
        std::uint64_t count;
    };
    void compact(const Progress& progress);

    std::size_t column_count_;
    std::uint64_t budget_bytes_;
    std::vector<Row> rows_;
    std::size_t sorted_count_ = 0;
};

/// Finds rows of a table that is sorted.
class RowFinder {
public:
    explicit RowFinder(const CountedMaterials& table) : table_(table) {}
    /// The number of a row that is there.
    [[nodiscard]] std::uint32_t number_of(std::span<const std::uint32_t> row) const;
    /// Those of another table's rows.
    [[nodiscard]] std::vector<std::uint32_t> numbers_of(const std::vector<AttributeColumn>& columns) const;

private:
    const CountedMaterials& table_;
};
} // namespace tyndall::voxel_dag
