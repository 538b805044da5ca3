// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/dag_file.hpp"
#include "voxel_dag/stored_top.hpp"
#include "voxel_dag/tdag_sections.hpp"
#include <functional>
#include <span>

namespace tyndall::voxel_dag {
namespace tdag {
namespace {
constexpr std::uint64_t alignment = 64; ///< Of sections.
std::uint64_t aligned(std::uint64_t offset) { return (offset + alignment - 1) / alignment * alignment; }

/// What a section has, in one piece or in several.
using Pieces = std::function<void(const std::function<void(std::span<const std::byte>)>&)>;

/// Sections in their order, and the table of them.
class Sections {
public:
    template <class Values>
    void append(Kind kind, std::uint32_t level, const Values& values) {
        const auto bytes = std::as_bytes(std::span(values));
        append_pieces(kind, level, bytes.size(), [bytes](const auto& use) { use(bytes); });
    }
    void append(Kind kind, const run_array::Encoder& array) {
        append_pieces(kind, 0, array.byte_count(), [&array](const auto& use) {
            array.read([&](std::span<const std::uint8_t> bytes) { use(std::as_bytes(bytes)); });
        });
    }
    /// Checksums are known when all is written: what comes first is written last.
    void write(Header header, const std::filesystem::path& path, const Progress& progress) {
        std::uint64_t end = sizeof(Header) + table_.size() * sizeof(Section);
        for (Section& section : table_) {
            section.offset = aligned(end);
            end = section.offset + section.bytes;
        }
        header.file_bytes = end;
        header.section_count = static_cast<std::uint32_t>(table_.size());
        FileWriter writer(path, progress);
        for (std::size_t i = 0; i < table_.size(); ++i) {
            writer.pad_to(table_[i].offset);
            table_[i].checksum = checksum_of({});
            contents_[i]([&](std::span<const std::byte> bytes) {
                table_[i].checksum = checksum_of(bytes, table_[i].checksum);
                writer.write(bytes);
            });
        }
        header.table_checksum = checksum_of(std::as_bytes(std::span(table_)));
        header.checksum = header_checksum(header);
        writer.rewrite(0, bytes_of(header));
        writer.rewrite(sizeof(Header), std::as_bytes(std::span(table_)));
        writer.complete();
    }

private:
    void append_pieces(Kind kind, std::uint32_t level, std::uint64_t bytes, Pieces pieces) {
        table_.push_back({kind, level, 0, bytes, 0, 0});
        contents_.push_back(std::move(pieces));
    }
    std::vector<Section> table_;
    std::vector<Pieces> contents_;
};

/// `streamed` has the numbers that `attributes` lacks; either may be null.
void write(const PackedDag& dag, const Cube& bounds_m, const AttributeParts* attributes,
           const StreamedAttributes* streamed, const std::filesystem::path& path, const Progress& progress) {
    std::vector<Format> formats;
    for (const PackedLevel& level : dag.levels)
        formats.push_back({{level.classes.widths, level.classes.begins, level.field_bits, level.mask_classes.widths,
                            level.mask_classes.begins, level.child_masks},
                           level.tags});
    Sections sections;
    std::vector<std::uint8_t> streamed_means;
    if (streamed != nullptr && streamed->means)
        streamed->means->read([&](std::span<const std::uint8_t> bytes) {
            streamed_means.insert(streamed_means.end(), bytes.begin(), bytes.end());
        });
    const std::vector<TopLevel> top =
        attributes == nullptr
            ? stored_top(dag, progress)
            : stored_top(dag, *attributes, streamed != nullptr ? streamed_means : attributes->means.indices, progress);
    for (std::uint32_t i = 0; i < top.size(); ++i) {
        sections.append(Kind::TopMasks, i + 1, top[i].child_masks);
        if (!top[i].colors.empty())
            sections.append(Kind::TopColors, i + 1, top[i].colors);
    }
    sections.append(Kind::Formats, 0, formats);
    for (std::size_t i = dag.levels.size(); i-- > 0;)
        sections.append(Kind::Directory, static_cast<std::uint32_t>(i) + leaf_level + 1, dag.levels[i].directory);
    sections.append(Kind::Leaves, 0, dag.leaves);
    sections.append(Kind::Pairs, 0, dag.pairs);
    sections.append(Kind::Records, 0, dag.records);
    std::vector<std::uint8_t> names;
    if (attributes != nullptr) {
        const auto append_numbers = [&](Kind kind, const std::vector<std::uint8_t>& in_memory,
                                        const run_array::Encoder* array) {
            if (array != nullptr)
                sections.append(kind, *array);
            else
                sections.append(kind, 0, in_memory);
        };
        names = encode_names(*attributes);
        sections.append(Kind::Attributes, 0, names);
        for (std::size_t i = attributes->order.directories.size(); i-- > 0;)
            sections.append(Kind::CountDirectory, static_cast<std::uint32_t>(i) + counted_level,
                            attributes->order.directories[i]);
        sections.append(Kind::Counts, 0, attributes->order.counts);
        sections.append(Kind::Materials, 0, attributes->voxels.materials);
        append_numbers(Kind::Indices, attributes->voxels.indices, streamed ? streamed->voxels.get() : nullptr);
        sections.append(Kind::MeanMaterials, 0, attributes->means.materials);
        append_numbers(Kind::MeanIndices, attributes->means.indices, streamed ? streamed->means.get() : nullptr);
    }
    sections.write({.magic = magic,
                    .version = version,
                    .level = dag.level,
                    .tag_bits = dag.tag_bits,
                    .leaf_bits = dag.leaf_bits,
                    .root_bit = dag.root_bit,
                    .voxel_count = dag.voxel_count,
                    .node_count = dag.node_count,
                    .file_bytes = 0,
                    .lower_m = {bounds_m.lower_m.x, bounds_m.lower_m.y, bounds_m.lower_m.z},
                    .side_m = bounds_m.side_m,
                    .section_count = 0,
                    .table_checksum = 0,
                    .reserved = 0,
                    .checksum = 0},
                   path, progress);
}
} // namespace
} // namespace tdag

void write_dag(const PlacedDag& placed, const std::filesystem::path& path, const Progress& progress) {
    tdag::write(placed.dag, placed.bounds_m, placed.attributes ? &placed.attributes->parts() : nullptr, nullptr, path,
                progress);
}
void write_dag(const PackedDag& dag, const Cube& bounds_m, const StreamedAttributes& attributes,
               const std::filesystem::path& path, const Progress& progress) {
    tdag::write(dag, bounds_m, &attributes.parts, &attributes, path, progress);
}
void write_dag(const PackedDag& dag, const Cube& bounds_m, const std::filesystem::path& path,
               const Progress& progress) {
    tdag::write(dag, bounds_m, nullptr, nullptr, path, progress);
}
} // namespace tyndall::voxel_dag
