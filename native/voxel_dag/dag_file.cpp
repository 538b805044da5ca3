// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/dag_file.hpp"
#include "voxel_dag/checked_file.hpp"
#include "voxel_dag/cube_group.hpp"
#include "voxel_dag/sound_dag.hpp"
#include "voxel_dag/stored_top.hpp"
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <numeric>
#include <set>
#include <span>

namespace tyndall::voxel_dag {
namespace {
static_assert(std::endian::native == std::endian::little, "files are little-endian, and read as they lie");

constexpr std::array<char, 8> magic{'T', 'D', 'A', 'G', '\r', '\n', '\x1a', '\n'}; // shows what text mode does to it
constexpr std::uint32_t version = 2; // 1: other records, and other numbers of materials, which run_array.cpp refuses
constexpr std::uint64_t alignment = 64;

struct Header {
    std::array<char, 8> magic;
    std::uint32_t version, level, tag_bits, leaf_bits;
    std::uint64_t root_bit, voxel_count, node_count, file_bytes;
    std::array<double, 3> lower_m;
    double side_m;
    std::uint32_t section_count, table_checksum, reserved, checksum; ///< The last of all that is before it.
};
static_assert(sizeof(Header) == 104);

enum class Kind : std::uint32_t {
    Formats = 1,
    Directory = 2,
    Records = 3,
    Pairs = 4,
    Leaves = 5,
    Attributes = 6, ///< What there is of those below.
    CountDirectory = 7,
    Counts = 8,
    Materials = 9,
    Indices = 10,
    MeanMaterials = 11,
    MeanIndices = 12,
    TopMasks = 13, ///< Of the topmost levels, coarsest first, before all others.
    TopColors = 14,
};
struct Section {
    Kind kind;
    std::uint32_t
        level; ///< Of a directory: its nodes have 2^level voxels a side; of a topmost level, 2^level cubes lie
               ///< along a side. Else 0.
    std::uint64_t offset, bytes;
    std::uint32_t checksum, reserved;
};
static_assert(sizeof(Section) == 32);

/// How one level names what is below it, and its child masks.
struct Format1 { ///< Of version 1: tags were named by their numbers.
    std::array<std::uint32_t, 4> widths, begins, field_bits, mask_widths, mask_begins;
    std::array<std::uint8_t, 256> child_masks;
};
static_assert(sizeof(Format1) == 336);
struct Format {
    Format1 first;
    std::array<std::uint8_t, 64> tags;
};
static_assert(sizeof(Format) == 400);

std::string name_of(const Section& section) {
    switch (section.kind) {
    case Kind::Formats:
        return "the formats of the levels";
    case Kind::Directory:
        return "the directory of level " + std::to_string(section.level);
    case Kind::Records:
        return "the records";
    case Kind::Pairs:
        return "the pairs of leaves and tags";
    case Kind::Leaves:
        return "the leaves";
    case Kind::Attributes:
        return "the names of the attributes";
    case Kind::CountDirectory:
        return "the directory of counts of level " + std::to_string(section.level);
    case Kind::Counts:
        return "the counts of voxels";
    case Kind::Materials:
        return "the materials";
    case Kind::Indices:
        return "the voxels' materials";
    case Kind::MeanMaterials:
        return "the materials of means";
    case Kind::MeanIndices:
        return "the nodes' means";
    case Kind::TopMasks:
        return "the cubes of topmost level " + std::to_string(section.level);
    case Kind::TopColors:
        return "the colours of topmost level " + std::to_string(section.level);
    }
    return "a section of an unknown kind";
}

std::vector<Format> read_formats(const FileReader& reader, const Header& header, const Section& section) {
    if (header.version > 1)
        return reader.values<Format>(section);
    std::array<std::uint8_t, 64> tags{};
    std::iota(tags.begin(), tags.begin() + cube_element_count, std::uint8_t{0});
    std::vector<Format> formats;
    for (const Format1& format : reader.values<Format1>(section))
        formats.push_back({format, tags});
    return formats;
}

std::uint64_t aligned(std::uint64_t offset) { return (offset + alignment - 1) / alignment * alignment; }

std::uint32_t header_checksum(const Header& header) {
    return checksum_of(bytes_of(header).first(offsetof(Header, checksum)));
}

Header read_header(const FileReader& reader) {
    Header header{};
    reader.read(0, std::as_writable_bytes(std::span(&header, 1)), "its header");
    if (header.magic != magic)
        reader.refuse("it is no .tdag file");
    if (header.version > version)
        reader.refuse("it is of version " + std::to_string(header.version) + ", this Tyndall reads up to " +
                      std::to_string(version) + ": install a newer one");
    if (header.checksum != header_checksum(header))
        reader.refuse("its header is damaged: copy or save the file again");
    if (header.file_bytes != reader.size())
        reader.refuse("it has " + std::to_string(reader.size()) + " bytes instead of " +
                      std::to_string(header.file_bytes) + ": copy or save it again");
    if (header.level > most_level)
        reader.refuse("it has 2^" + std::to_string(header.level) + " voxels a side");
    if (!std::ranges::all_of(header.lower_m, [](double at) { return std::isfinite(at); }) ||
        !(header.side_m > 0.0 && std::isfinite(header.side_m)))
        reader.refuse("its cube is nowhere in space");
    return header;
}

std::vector<Section> read_table(const FileReader& reader, const Header& header) {
    constexpr std::size_t most_sections = 4096; // more than any version has
    if (header.section_count > most_sections)
        reader.refuse("it has " + std::to_string(header.section_count) + " sections");
    std::vector<Section> table(header.section_count);
    reader.read(sizeof(Header), std::as_writable_bytes(std::span(table)), "its table of sections");
    if (checksum_of(std::as_bytes(std::span(table))) != header.table_checksum)
        reader.refuse("its table of sections is damaged: copy or save the file again");
    // What is read takes no more memory than the file, whatever the table says.
    std::uint64_t bytes = 0;
    std::set<std::pair<Kind, std::uint32_t>> known;
    for (const Section& section : table) {
        if (!known.emplace(section.kind, section.level).second)
            reader.refuse("it has " + name_of(section) + " twice");
        if (section.bytes > reader.size() - bytes)
            reader.refuse("its sections have more bytes than it has");
        bytes += section.bytes;
    }
    return table;
}
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
} // namespace

/// `streamed` has the numbers that `attributes` lacks; either may be null.
static void write(const PackedDag& dag, const Cube& bounds_m, const AttributeParts* attributes,
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

void write_dag(const PlacedDag& placed, const std::filesystem::path& path, const Progress& progress) {
    write(placed.dag, placed.bounds_m, placed.attributes ? &placed.attributes->parts() : nullptr, nullptr, path,
          progress);
}
void write_dag(const PackedDag& dag, const Cube& bounds_m, const StreamedAttributes& attributes,
               const std::filesystem::path& path, const Progress& progress) {
    write(dag, bounds_m, &attributes.parts, &attributes, path, progress);
}
void write_dag(const PackedDag& dag, const Cube& bounds_m, const std::filesystem::path& path,
               const Progress& progress) {
    write(dag, bounds_m, nullptr, nullptr, path, progress);
}

static void read_top_section(const FileReader& reader, const Header& header, const Section& section,
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

PlacedDag read_dag(const std::filesystem::path& path, const Progress& progress, bool has_attributes) {
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
