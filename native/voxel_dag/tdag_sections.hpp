// SPDX-License-Identifier: GPL-3.0-or-later
// What a .tdag file begins with, and how its sections are named: docs/tdag.md describes every byte. Between writer and reader.
#pragma once
#include "voxel_dag/checked_file.hpp"
#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <vector>

namespace tyndall::voxel_dag::tdag {
static_assert(std::endian::native == std::endian::little, "files are little-endian, and read as they lie");

/// The ends of lines show what text mode does to it.
inline constexpr std::array<char, 8> magic{'T', 'D', 'A', 'G', '\r', '\n', '\x1a', '\n'};
/// 1: other records. 1 and 2: other numbers of materials, which run_array.cpp refuses.
inline constexpr std::uint32_t version = 3;

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
    /// Of a directory: its nodes have 2^level voxels a side; of a topmost level, 2^level cubes lie along a side. Else 0.
    std::uint32_t level;
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

/// As errors say it.
[[nodiscard]] std::string name_of(const Section& section);
/// Of all that is before it in the header.
[[nodiscard]] std::uint32_t header_checksum(const Header& header);
/// Throw IoError where they are damaged, or of a later version.
[[nodiscard]] Header read_header(const FileReader& reader);
[[nodiscard]] std::vector<Section> read_table(const FileReader& reader, const Header& header);
/// Of any version, as of the last one.
[[nodiscard]] std::vector<Format> read_formats(const FileReader& reader, const Header& header, const Section& section);
} // namespace tyndall::voxel_dag::tdag
