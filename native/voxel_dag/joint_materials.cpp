// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/joint_materials.hpp"
#include "voxel_dag/byte_sections.hpp"
#include "voxel_dag/material_indices.hpp"
#include "voxel_dag/numbered_values.hpp"

namespace tyndall::voxel_dag {
static constexpr std::uint32_t materials_mark = 0x314d4a54; // "TJM1"
static constexpr std::size_t poll_entries = std::size_t{1} << 20;

/// The combinations of one number more: below 2^64, because each number is below 2^32.
static void join_one(JointMaterials& joint, MaterialIndices added, const Progress& progress) {
    NumberedValues<std::uint64_t> combinations;
    std::uint64_t before = 0;
    std::uint32_t number = 0;
    for (std::size_t i = 0; i < joint.indices.size(); ++i) {
        if (i % poll_entries == 0)
            progress.poll();
        const std::uint64_t combination = std::uint64_t{joint.indices[i]} << 32 | added.indices[i];
        if (i == 0 || combination != before)
            number = combinations.number_of(combination);
        before = combination;
        joint.indices[i] = number;
    }
    const AscendingOrder order(combinations.values());
    for (std::uint32_t& index : joint.indices)
        index = order.rank[index];
    for (std::vector<std::uint32_t>& column : joint.columns) {
        std::vector<std::uint32_t> longer;
        for (const std::uint64_t combination : order.values)
            longer.push_back(column[combination >> 32]);
        column = std::move(longer);
    }
    joint.columns.emplace_back();
    for (const std::uint64_t combination : order.values)
        joint.columns.back().push_back(added.materials[combination & 0xffffffff]);
}

JointMaterials join(std::span<const std::span<const std::uint32_t>> attributes, const Progress& progress) {
    require(!attributes.empty(), "joint materials: there is no attribute");
    for (std::size_t k = 0; k < attributes.size(); ++k)
        require(attributes[k].size() == attributes[0].size(), "joint materials: attribute ", k, " has ",
                attributes[k].size(), " entries, attribute 0 has ", attributes[0].size());
    MaterialIndices first = material_indices_of(attributes[0], progress);
    JointMaterials joint{.columns = {std::move(first.materials)}, .indices = std::move(first.indices)};
    for (const auto& attribute : attributes.subspan(1))
        join_one(joint, material_indices_of(attribute, progress), progress);
    return joint;
}

std::vector<std::uint8_t> encode_columns(const std::vector<std::vector<std::uint32_t>>& columns) {
    const std::size_t material_count = columns.at(0).size();
    SectionWriter writer;
    writer.number(materials_mark);
    writer.number(static_cast<std::uint32_t>(material_count));
    writer.number(static_cast<std::uint32_t>(columns.size()));
    const auto width_of = [](const std::vector<std::uint32_t>& column) {
        return column.empty() ? 0 : bits_for(std::uint64_t{std::ranges::max(column)} + 1);
    };
    for (const std::vector<std::uint32_t>& column : columns)
        writer.number(width_of(column));
    for (const std::vector<std::uint32_t>& column : columns) {
        const std::uint32_t width = width_of(column);
        BitPacker bits;
        for (const std::uint32_t value : column)
            bits.append(value, width);
        writer.packed(bits);
    }
    return writer.finish();
}

MaterialTable::MaterialTable(std::span<const std::uint8_t> bytes) {
    SectionReader reader(bytes, "material table");
    reader.check(reader.number<std::uint32_t>("header") == materials_mark, "header", "does not begin with its mark");
    material_count_ = reader.number<std::uint32_t>("header");
    const auto attribute_count = reader.number<std::uint32_t>("header");
    reader.check(attribute_count <= bytes.size() / sizeof(std::uint32_t), "header", "has ", attribute_count,
                 " attributes, more than there are bytes for");
    for (std::uint32_t k = 0; k < attribute_count; ++k) {
        columns_.push_back({nullptr, reader.number<std::uint32_t>("widths")});
        reader.check(columns_.back().value_bits <= 32, "widths", "has values of ", columns_.back().value_bits, " bits");
    }
    for (Column& column : columns_)
        column.bytes = reader.take_packed(material_count_, column.value_bits, "values").data();
    reader.finish();
}

std::uint32_t MaterialTable::at(std::uint32_t material, std::uint32_t attribute) const {
    const Column& column = columns_[attribute];
    return static_cast<std::uint32_t>(
        read_bits(column.bytes, std::uint64_t{material} * column.value_bits, column.value_bits));
}
} // namespace tyndall::voxel_dag
