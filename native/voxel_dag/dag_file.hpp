// SPDX-License-Identifier: GPL-3.0-or-later
// A packed DAG in a file, .tdag: a header, a table of sections, and the sections as they lie in memory, so that a file that
// is mapped can be followed in place; each has a checksum. docs/tdag.md describes every byte.
// Bound:    the DAG's bytes, written once; read and checked once, at zlib's 1 to 3 GB/s.
#pragma once
#include "core/progress.hpp"
#include "voxel_dag/dag_attributes.hpp"
#include "voxel_dag/top_levels.hpp"
#include "voxel_dag/voxelize.hpp"
#include <filesystem>

namespace tyndall::voxel_dag {
/// Voxels of a cube somewhere in space.
struct PlacedDag {
    PackedDag dag;
    Cube bounds_m;
    std::shared_ptr<const DagAttributes> attributes = nullptr; ///< Of dag; null: its voxels carry nothing.
};

/// Attributes whose numbers of materials are not in memory.
struct StreamedAttributes {
    AttributeParts parts;                              ///< Without the numbers.
    std::unique_ptr<run_array::Encoder> voxels, means; ///< No means where no node is that large.

    [[nodiscard]] std::uint64_t byte_count() const {
        return parts.byte_count() + voxels->byte_count() + (means ? means->byte_count() : 0);
    }
};

/// The file appears whole or not at all. Throws IoError, which names the path and why, and Cancelled.
void write_dag(const PlacedDag& placed, const std::filesystem::path& path, const Progress& progress);
/// With attributes that are not in memory.
void write_dag(const PackedDag& dag, const Cube& bounds_m, const StreamedAttributes& attributes,
               const std::filesystem::path& path, const Progress& progress);
/// Without attributes.
void write_dag(const PackedDag& dag, const Cube& bounds_m, const std::filesystem::path& path, const Progress& progress);
/// Throws IoError, which names the path, and the section that is damaged or missing; and Cancelled.
/// Without attributes, these are not read.
[[nodiscard]] PlacedDag read_dag(const std::filesystem::path& path, const Progress& progress,
                                 bool has_attributes = true);

struct TopOfDag {
    Cube bounds_m;
    std::vector<TopLevel> levels;
};
/// So many of a file's topmost levels, at least leaf_level, without reading the rest; nothing where it has fewer. Throws as
/// read_dag().
[[nodiscard]] std::optional<TopOfDag> read_top(const std::filesystem::path& path, std::uint32_t level,
                                               const Progress& progress);
} // namespace tyndall::voxel_dag
