// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/part_file.hpp"
#include "voxel_dag/checked_file.hpp"
#include <algorithm>
#include <bit>
#include <span>
#include <type_traits>

namespace tyndall::voxel_dag {
namespace {
constexpr std::array<char, 8> part_magic{'T', 'D', 'A', 'G', 'P', 'A', 'R', 'T'};
constexpr std::uint32_t part_version = 2;
/// Of attributes.
enum Number : std::size_t {
    Columns,
    VoxelCounts,
    Indices,
    MeanColumns,
    MeanCounts,
    MeanIndices,
    MeanSums,
    section_count
};
constexpr std::size_t most_levels = most_level - leaf_level;

struct PartHeader {
    std::array<char, 8> magic;
    std::uint32_t version, level, symmetry, root_tag;
    std::array<std::uint64_t, 2> job;
    std::uint64_t code, voxel_count, leaf_count;
    std::array<std::uint64_t, most_levels> node_counts, reference_counts;
    std::array<std::uint64_t, section_count> attribute_bytes;
    std::uint32_t leaf_checksum;
    std::array<std::uint32_t, most_levels> checksums;
    std::array<std::uint32_t, section_count> attribute_checksums;
    std::uint32_t checksum; ///< Of all that is before it.
};
static_assert(sizeof(PartHeader) == 456 && std::has_unique_object_representations_v<PartHeader>);

std::uint32_t header_checksum(const PartHeader& header) {
    return checksum_of(bytes_of(header).first(offsetof(PartHeader, checksum)));
}

/// A level as bytes: masks, tags and children.
std::vector<std::byte> bytes_of_level(const DagLevel& nodes) {
    std::vector<std::byte> bytes;
    bytes.reserve(nodes.child_masks.size() + nodes.tags.size() + 4 * nodes.children.size());
    const auto append = [&](const auto& values) {
        const auto more = std::as_bytes(std::span(values));
        bytes.insert(bytes.end(), more.begin(), more.end());
    };
    append(nodes.child_masks);
    append(nodes.tags);
    append(nodes.children);
    return bytes;
}
/// What is added up over parts.
struct PartSums {
    SampleSum sum;
    std::uint64_t angle_sum;
    double most_degrees;
};
static_assert(std::is_trivially_copyable_v<PartSums>);

std::vector<std::byte> bytes_of_columns(const std::vector<AttributeColumn>& columns) {
    std::vector<std::byte> bytes;
    for (const AttributeColumn& column : columns) {
        const auto more = std::as_bytes(std::span(column));
        bytes.insert(bytes.end(), more.begin(), more.end());
    }
    return bytes;
}
std::vector<AttributeColumn> columns_of(const std::vector<std::uint32_t>& values, std::size_t column_count) {
    std::vector<AttributeColumn> columns(column_count);
    const auto rows = static_cast<std::ptrdiff_t>(values.size() / column_count);
    for (std::size_t column = 0; column < column_count; ++column) {
        const auto begin = values.begin() + static_cast<std::ptrdiff_t>(column) * rows;
        columns[column].assign(begin, begin + rows);
    }
    return columns;
}
} // namespace

void write_part(const Dag& dag, const PartAttributes& attributes, const PartKey& key, std::uint64_t voxel_count,
                const std::filesystem::path& path, const Progress& progress) {
    PartHeader header{};
    header.magic = part_magic;
    header.version = part_version;
    header.level = dag.level;
    header.symmetry = static_cast<std::uint32_t>(dag.symmetry);
    header.root_tag = dag.root_tag;
    header.job = key.job;
    header.code = key.code;
    header.voxel_count = voxel_count;
    header.leaf_count = dag.leaves.size();
    header.leaf_checksum = checksum_of(std::as_bytes(std::span(dag.leaves)));
    std::vector<std::vector<std::byte>> levels;
    for (std::size_t i = 0; i < dag.levels.size(); ++i) {
        header.node_counts[i] = dag.levels[i].node_count();
        header.reference_counts[i] = dag.levels[i].children.size();
        levels.push_back(bytes_of_level(dag.levels[i]));
        header.checksums[i] = checksum_of(levels[i]);
    }
    const std::vector<std::byte> columns = bytes_of_columns(attributes.materials.columns),
                                 mean_columns = bytes_of_columns(attributes.means.columns);
    const PartSums sums{
        .sum = attributes.sum, .angle_sum = attributes.normals.sum, .most_degrees = attributes.normals.most_degrees};
    std::array<std::span<const std::byte>, section_count> contents{};
    if (!attributes.is_empty()) {
        contents[Columns] = columns;
        contents[VoxelCounts] = std::as_bytes(std::span(attributes.materials.counts));
        contents[Indices] = std::as_bytes(std::span(attributes.indices));
        contents[MeanColumns] = mean_columns;
        contents[MeanCounts] = std::as_bytes(std::span(attributes.means.counts));
        contents[MeanIndices] = std::as_bytes(std::span(attributes.mean_indices));
        contents[MeanSums] = bytes_of(sums);
    }
    for (std::size_t number = 0; number < section_count; ++number) {
        header.attribute_bytes[number] = contents[number].size();
        header.attribute_checksums[number] = checksum_of(contents[number]);
    }
    header.checksum = header_checksum(header);
    FileWriter writer(path, progress);
    writer.write(bytes_of(header));
    writer.write(std::as_bytes(std::span(dag.leaves)));
    for (const std::vector<std::byte>& level : levels)
        writer.write(level);
    for (const std::span<const std::byte> content : contents)
        writer.write(content);
    writer.complete();
}

std::string name_of(const PartFile::Section& section) {
    return section.level == leaf_level ? "the leaves" : "the nodes of level " + std::to_string(section.level);
}

std::string name_of(const PartFile::AttributeSection& section) {
    constexpr std::array names{"the materials", "the counts of materials", "the voxels' materials",
                               "the means",     "the counts of means",     "the nodes' means",
                               "the sums"};
    static_assert(names.size() == section_count);
    return names[section.number];
}

PartFile::PartFile(const std::filesystem::path& path, const PartKey& key, const Progress& progress)
    : path_(path), key_(key) {
    const FileReader reader(path, progress);
    PartHeader header{};
    reader.read(0, std::as_writable_bytes(std::span(&header, 1)), "its header");
    if (header.magic != part_magic || header.version != part_version || header.checksum != header_checksum(header))
        reader.refuse("it is no part of a voxel DAG of this version, or its header is damaged");
    if (header.job != key.job || header.level != key.level || header.code != key.code)
        reader.refuse("it is a part of another job");
    voxel_count_ = header.voxel_count;
    root_tag_ = static_cast<std::uint8_t>(header.root_tag);
    has_tags_ = header.symmetry != 0;
    sections_.push_back({.level = leaf_level,
                         .node_count = header.leaf_count,
                         .reference_count = 0,
                         .offset = sizeof(PartHeader),
                         .bytes = header.leaf_count * sizeof(std::uint64_t),
                         .checksum = header.leaf_checksum});
    const auto end = [&] { return sections_.back().offset + sections_.back().bytes; };
    for (std::uint32_t level = leaf_level + 1; level <= key.level; ++level) {
        const std::size_t i = level - leaf_level - 1;
        sections_.push_back({.level = level,
                             .node_count = header.node_counts[i],
                             .reference_count = header.reference_counts[i],
                             .offset = end(),
                             .bytes = header.node_counts[i] + header.reference_counts[i] * (has_tags_ ? 5 : 4),
                             .checksum = header.checksums[i]});
    }
    std::uint64_t offset = end();
    for (std::size_t number = 0; number < section_count; ++number) {
        attribute_sections_.push_back({.number = number,
                                       .offset = offset,
                                       .bytes = header.attribute_bytes[number],
                                       .checksum = header.attribute_checksums[number]});
        offset += header.attribute_bytes[number];
    }
    for (const Section& section : sections_)
        static_cast<void>(reader.values<std::byte>(section));
    for (const AttributeSection& section : attribute_sections_)
        static_cast<void>(reader.values<std::byte>(section));
}

std::vector<std::uint64_t> PartFile::read_leaves(const Progress& progress) const {
    return FileReader(path_, progress).values<std::uint64_t>(sections_.front());
}

DagLevel PartFile::read_level(std::uint32_t level, const Progress& progress) const {
    const std::vector<std::byte> bytes = FileReader(path_, progress).values<std::byte>(section(level));
    const std::size_t node_count = section(level).node_count, reference_count = section(level).reference_count;
    DagLevel nodes{.child_masks = std::vector<std::uint8_t>(node_count),
                   .first_children = {0},
                   .children = std::vector<std::uint32_t>(reference_count),
                   .tags = std::vector<std::uint8_t>(has_tags_ ? reference_count : 0)};
    std::span<const std::byte> rest = bytes;
    const auto take = [&rest](auto& values) {
        const std::span<std::byte> to = std::as_writable_bytes(std::span(values));
        std::ranges::copy(rest.first(to.size()), to.begin());
        rest = rest.subspan(to.size());
    };
    take(nodes.child_masks);
    take(nodes.tags);
    take(nodes.children);
    nodes.first_children.reserve(node_count + 1);
    for (const std::uint8_t mask : nodes.child_masks)
        nodes.first_children.push_back(nodes.first_children.back() + static_cast<std::uint32_t>(std::popcount(mask)));
    return nodes;
}

PartTables PartFile::read_tables(std::size_t column_count, const Progress& progress) const {
    const FileReader reader(path_, progress);
    const auto table_of = [&](std::size_t columns, std::size_t counts) {
        return CountedMaterials{
            .columns = columns_of(reader.values<std::uint32_t>(attribute_sections_[columns]), column_count),
            .counts = reader.values<std::uint64_t>(attribute_sections_[counts])};
    };
    const std::vector<PartSums> sums = reader.values<PartSums>(attribute_sections_[MeanSums]);
    if (sums.size() != 1)
        reader.refuse("it has no attributes");
    return {.materials = table_of(Columns, VoxelCounts),
            .means = table_of(MeanColumns, MeanCounts),
            .sum = sums.front().sum,
            .normals = {.sum = sums.front().angle_sum, .most_degrees = sums.front().most_degrees}};
}
std::vector<std::uint8_t> PartFile::read_indices(const Progress& progress) const {
    return FileReader(path_, progress).values<std::uint8_t>(attribute_sections_[Indices]);
}
std::vector<std::uint8_t> PartFile::read_mean_indices(const Progress& progress) const {
    return FileReader(path_, progress).values<std::uint8_t>(attribute_sections_[MeanIndices]);
}
} // namespace tyndall::voxel_dag
