// SPDX-License-Identifier: GPL-3.0-or-later
// Several attributes of a voxel as one: a material is a combination that occurs, and one array of material numbers takes
// the place of an array per attribute.
// Based on: Kol, dissertation, TU Delft 2018, section 2.5.2: colours, normals and reflectances that change together cost
//           25.8 % more than colours alone, for 150 % more data.
// Differs:  materials are in the order of their first attribute, then the second, and so on, whatever the voxels' order.
// Bound:    a table in a hash per attribute and run of equal combinations; bits of a value as many as its column needs.
#pragma once
#include "core/progress.hpp"
#include <cstdint>
#include <span>
#include <vector>

namespace tyndall::voxel_dag {
struct JointMaterials {
    std::vector<std::vector<std::uint32_t>> columns; ///< Per attribute its value of each material.
    std::vector<std::uint32_t> indices;              ///< Per entry its material.
};
/// attributes[k] holds attribute k of every entry. Throws InvalidInput, which names the first of another length, and
/// Cancelled.
[[nodiscard]] JointMaterials join(std::span<const std::span<const std::uint32_t>> attributes, const Progress& progress);

/// Bytes of columns, one at least.
[[nodiscard]] std::vector<std::uint8_t> encode_columns(const std::vector<std::vector<std::uint32_t>>& columns);
[[nodiscard]] inline std::vector<std::uint8_t> encode_columns(const JointMaterials& materials) {
    return encode_columns(materials.columns);
}

/// Reads what encode_columns() wrote, in place: the bytes stay the caller's.
class MaterialTable {
public:
    /// Throws InvalidInput, which names the section that is damaged or cut off.
    explicit MaterialTable(std::span<const std::uint8_t> bytes);

    [[nodiscard]] std::uint32_t material_count() const { return material_count_; }
    [[nodiscard]] std::uint32_t attribute_count() const { return static_cast<std::uint32_t>(columns_.size()); }
    /// Both below their counts.
    [[nodiscard]] std::uint32_t at(std::uint32_t material, std::uint32_t attribute) const;

private:
    struct Column {
        const std::uint8_t* bytes;
        std::uint32_t value_bits;
    };
    std::uint32_t material_count_ = 0;
    std::vector<Column> columns_;
};
} // namespace tyndall::voxel_dag
