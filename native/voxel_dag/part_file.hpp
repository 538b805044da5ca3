// SPDX-License-Identifier: GPL-3.0-or-later
// The DAG of one sub-cube, and what its voxels carry, in a file of its own: what is finished of a job, and survives its end.
// Differs:  not packed: levels are read one at a time, as arrays. A checksum for each level, and the job's name, so that
//           a part of another mesh, of other settings, or damaged on its way, is never taken for the one that is wanted.
// Bound:    8 bytes per leaf; per node 1, and 5 per child; numbers of materials as run arrays, materials as they are.
#pragma once
#include "core/progress.hpp"
#include "voxel_dag/dag.hpp"
#include "voxel_dag/part_attributes.hpp"
#include <array>
#include <filesystem>

namespace tyndall::voxel_dag {
/// Which part of which job.
struct PartKey {
    std::array<std::uint64_t, 2> job; ///< A Fingerprint.
    std::uint32_t level;              ///< 2^level voxels a side.
    std::uint64_t code;               ///< Morton code among cubes of this size.
};

/// The file appears whole or not at all. attributes: those of the voxels, or empty ones. Throws IoError, which names the
/// path and why, and Cancelled.
void write_part(const Dag& dag, const PartAttributes& attributes, const PartKey& key, std::uint64_t voxel_count,
                const std::filesystem::path& path, const Progress& progress);

/// Of a part's attributes, all that does not grow with its voxels.
struct PartTables {
    CountedMaterials materials, means;
    SampleSum sum;
    NormalErrors normals;
};

class PartFile {
public:
    /// Reads and checks all of it, and keeps none of its levels. Throws IoError, which names the path and what is damaged
    /// or wrong with it, and Cancelled.
    PartFile(const std::filesystem::path& path, const PartKey& key, const Progress& progress);

    [[nodiscard]] std::uint64_t code() const { return key_.code; }
    [[nodiscard]] std::uint64_t voxel_count() const { return voxel_count_; }
    [[nodiscard]] std::uint64_t byte_count() const {
        return attribute_sections_.back().offset + attribute_sections_.back().bytes;
    }
    [[nodiscard]] std::uint8_t root_tag() const { return root_tag_; }
    [[nodiscard]] bool is_empty() const { return sections_.front().node_count == 0; }
    /// Of nodes of 2^level voxels a side, leaves among them.
    [[nodiscard]] std::size_t node_count(std::uint32_t level) const { return section(level).node_count; }
    [[nodiscard]] std::size_t reference_count(std::uint32_t level) const { return section(level).reference_count; }
    [[nodiscard]] std::vector<std::uint64_t> read_leaves(const Progress& progress) const;
    [[nodiscard]] DagLevel read_level(std::uint32_t level, const Progress& progress) const;
    /// The different ones, and the sums that go with all of them; column_count as in the layout.
    [[nodiscard]] PartTables read_tables(std::size_t column_count, const Progress& progress) const;
    /// Run arrays: by voxel, and by node of 16^3 or more.
    [[nodiscard]] std::vector<std::uint8_t> read_indices(const Progress& progress) const;
    [[nodiscard]] std::vector<std::uint8_t> read_mean_indices(const Progress& progress) const;

private:
    struct Section {
        std::uint32_t level;
        std::size_t node_count, reference_count;
        std::uint64_t offset, bytes;
        std::uint32_t checksum;
    };
    struct AttributeSection {
        std::size_t number; ///< In the order in which they lie in the file.
        std::uint64_t offset, bytes;
        std::uint32_t checksum;
    };
    friend std::string name_of(const Section& section);
    friend std::string name_of(const AttributeSection& section);
    [[nodiscard]] const Section& section(std::uint32_t level) const { return sections_[level - leaf_level]; }

    std::filesystem::path path_;
    PartKey key_;
    std::uint64_t voxel_count_ = 0;
    std::uint8_t root_tag_ = 0;
    bool has_tags_ = false;
    std::vector<Section> sections_; ///< The leaves, and each level above them.
    std::vector<AttributeSection> attribute_sections_;
};
} // namespace tyndall::voxel_dag
