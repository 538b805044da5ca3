// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/dag_file.hpp"
#include "voxel_dag/sound_dag.hpp"
#include "voxel_dag/stored_top.hpp"
#include "voxel_dag/tdag_sections.hpp"
#include <algorithm>

namespace tyndall::voxel_dag {
namespace tdag {
namespace {
void read_top_section(const FileReader& reader, const Header& header, const Section& section,
                      std::vector<TopLevel>& top) {
    if (section.level == 0 || section.level > header.level)
        reader.refuse(name_of(section) + " belong to no level");
    top.resize(std::max(top.size(), std::size_t{section.level}));
    if (section.kind == Kind::TopColors) {
        top[section.level - 1].colors = reader.values<ByteColor>(section);
        return;
    }
    // Each byte of these becomes up to 64 of codes: without this a file of 1 GB could ask for 64.
    if (section.bytes > reader.size() / top_share)
        reader.refuse(name_of(section) + " take more than their share");
    top[section.level - 1].child_masks = reader.values<std::uint8_t>(section);
}
} // namespace
} // namespace tdag

PlacedDag read_dag(const std::filesystem::path& path, const Progress& progress, bool has_attributes) {
    using namespace tdag;
    const FileReader reader(path, progress);
    const Header header = read_header(reader);
    PackedDag dag{.level = header.level,
                  .tag_bits = header.tag_bits,
                  .leaf_bits = header.leaf_bits,
                  .leaves = {},
                  .pairs = {},
                  .records = {},
                  .levels = {},
                  .root_bit = header.root_bit,
                  .voxel_count = header.voxel_count,
                  .node_count = header.node_count};
    std::optional<AttributeParts> parts;
    const auto attributes = [&]() -> AttributeParts& { return parts ? *parts : parts.emplace(); };
    std::vector<std::uint8_t> names;
    std::vector<TopLevel> top;
    std::vector<Section> table = read_table(reader, header);
    if (!has_attributes)
        std::erase_if(table, [](const Section& section) { return section.kind >= Kind::Attributes; });
    for (const Section& section : table)
        switch (section.kind) {
        case Kind::Formats:
            for (std::size_t i = 0; const auto& [format, tags] : read_formats(reader, header, section)) {
                dag.levels.resize(std::max(dag.levels.size(), i + 1));
                dag.levels[i].tags = tags;
                dag.levels[i].classes = {.widths = format.widths, .begins = format.begins};
                dag.levels[i].mask_classes = {.widths = format.mask_widths, .begins = format.mask_begins};
                dag.levels[i].child_masks = format.child_masks;
                dag.levels[i++].field_bits = format.field_bits;
            }
            break;
        case Kind::Directory:
            if (section.level <= leaf_level || section.level > most_level)
                reader.refuse(name_of(section) + " belongs to no level");
            dag.levels.resize(std::max(dag.levels.size(), std::size_t{section.level - leaf_level}));
            dag.levels[section.level - leaf_level - 1].directory = reader.values<std::uint32_t>(section);
            break;
        case Kind::Leaves:
            dag.leaves = reader.values<std::uint64_t>(section);
            break;
        case Kind::Pairs:
            dag.pairs = reader.values<std::uint64_t>(section);
            break;
        case Kind::Records:
            dag.records = reader.values<std::uint64_t>(section);
            break;
        case Kind::Attributes:
            attributes();
            names = reader.values<std::uint8_t>(section);
            break;
        case Kind::CountDirectory: {
            if (section.level < counted_level || section.level > most_level)
                reader.refuse(name_of(section) + " belongs to no level");
            auto& directories = attributes().order.directories;
            directories.resize(std::max(directories.size(), std::size_t{section.level - counted_level + 1}));
            directories[section.level - counted_level] = reader.values<std::uint32_t>(section);
            break;
        }
        case Kind::Counts:
            attributes().order.counts = reader.values<std::uint64_t>(section);
            break;
        case Kind::Materials:
            attributes().voxels.materials = reader.values<std::uint8_t>(section);
            break;
        case Kind::Indices:
            attributes().voxels.indices = reader.values<std::uint8_t>(section);
            break;
        case Kind::MeanMaterials:
            attributes().means.materials = reader.values<std::uint8_t>(section);
            break;
        case Kind::MeanIndices:
            attributes().means.indices = reader.values<std::uint8_t>(section);
            break;
        case Kind::TopMasks: // for read_top(); damage is found here, too
        case Kind::TopColors:
            read_top_section(reader, header, section, top);
            break;
        default: // of a kind that came later, and that this version can do without
            break;
        }
    std::shared_ptr<const DagAttributes> kept;
    try {
        require_usable(dag);
        if (parts) {
            decode_names(names, *parts);
            kept = std::make_shared<const DagAttributes>(std::move(*parts), dag);
        }
        require_sound(dag, kept ? &kept->parts().order : nullptr, progress);
        require_top_of(dag, top, progress);
    } catch (const InvalidInput& error) {
        reader.refuse(error.what());
    }
    return {.dag = std::move(dag),
            .bounds_m = {.lower_m = dvec3(header.lower_m[0], header.lower_m[1], header.lower_m[2]),
                         .side_m = header.side_m},
            .attributes = std::move(kept)};
}

std::optional<TopOfDag> read_top(const std::filesystem::path& path, std::uint32_t level, const Progress& progress) {
    using namespace tdag;
    const FileReader reader(path, progress);
    const Header header = read_header(reader);
    TopOfDag top{.bounds_m = {.lower_m = dvec3(header.lower_m[0], header.lower_m[1], header.lower_m[2]),
                              .side_m = header.side_m},
                 .levels = {}};
    for (const Section& section : read_table(reader, header)) {
        if ((section.kind != Kind::TopMasks && section.kind != Kind::TopColors) || section.level > level)
            continue;
        read_top_section(reader, header, section, top.levels);
    }
    if (top.levels.size() < level)
        return std::nullopt;
    try {
        static_cast<void>(voxels_of(top.levels));
    } catch (const InvalidInput& error) {
        reader.refuse(error.what());
    }
    return top;
}
} // namespace tyndall::voxel_dag
