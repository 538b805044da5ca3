// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/tdag_sections.hpp"
#include "voxel_dag/cube_group.hpp"
#include "voxel_dag/leaf_masks.hpp"
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <set>
#include <span>
#include <utility>

namespace tyndall::voxel_dag::tdag {
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
} // namespace tyndall::voxel_dag::tdag
