// SPDX-License-Identifier: GPL-3.0-or-later
// What voxels carry as numbers of joint materials: normals already as short as they are kept, colours as they were given,
// because a palette is chosen for all voxels together, however many parts they come in.
// Based on: Kol, dissertation 2018, 2.4.2, 2.4.3 and 2.5.2: joint materials; fewer colours; normals of fewer bits.
// Differs:  a palette is made of the table's different colours and how often each comes: of parts' tables it is the one of
//           all voxels at once, bit by bit. Errors of normals are added up as whole numbers for the same reason.
// Bound:    per voxel 8 bytes, and 4 for normals that are shortened and for each channel; the tables of different values.
#pragma once
#include "voxel_dag/dag_attributes.hpp"
#include "voxel_dag/surface_attributes.hpp"

namespace tyndall::voxel_dag {
/// As they are, every value comes back as it was given.
struct AttributeConfig {
    std::uint32_t color_count = 0;      ///< At most so many colours, [1, 65536]; 0: as many as there are.
    double most_color_difference = 0.0; ///< CIE94, of any voxel's colour, [0.01, 100]; 0: none. One of both at most.
    std::uint32_t normal_bits = 32;     ///< [8, 32]: 32 keeps the codes.
    bool has_means = true;              ///< Of nodes of 16^3 and more, for levels of detail.
    std::uint64_t memory_budget_bytes = ~std::uint64_t{0}; ///< With what was given, and beside the DAG.

    [[nodiscard]] bool has_palette() const { return color_count > 0 || most_color_difference > 0.0; }
};
/// Throws InvalidInput, which names the setting.
void require_usable(const AttributeConfig& config);
/// Throws InvalidInput, which names the array.
void require_usable(const VoxelAttributes& attributes, std::uint64_t voxel_count);

using AttributeColumn = std::vector<std::uint32_t>;

/// Angles between normals that were given and those that are kept.
struct NormalErrors {
    std::uint64_t sum = 0; ///< In steps of 2^-20 degrees.
    double most_degrees = 0.0;

    NormalErrors& operator+=(const NormalErrors& other);
    [[nodiscard]] double mean_degrees(std::uint64_t voxel_count) const;
};
/// Different materials, in the order of their values, and how many voxels have each.
struct CountedMaterials {
    std::vector<AttributeColumn> columns;
    std::vector<std::uint64_t> counts;
};
struct GivenMaterials {
    AttributeLayout layout;
    CountedMaterials table;
    AttributeColumn indices; ///< By voxel, as attributes are.
    NormalErrors normals;
};
[[nodiscard]] AttributeLayout layout_of(const VoxelAttributes& attributes, const AttributeConfig& config);
/// Of what a mesh's surface gives its voxels.
[[nodiscard]] AttributeLayout layout_of(const Surface& surface, const AttributeConfig& config);
/// Throws InvalidInput, which names the array or the setting, or says that the budget does not suffice, and Cancelled.
[[nodiscard]] GivenMaterials given_materials(const VoxelAttributes& attributes, const AttributeConfig& config,
                                             const Progress& progress);

/// The materials that are stored, and which of them each of a table becomes.
struct KeptMaterials {
    std::vector<AttributeColumn> columns;
    std::vector<std::uint32_t> number_of;
    double mean_cie94 = 0.0, most_cie94 = 0.0;

    [[nodiscard]] std::uint32_t count() const { return static_cast<std::uint32_t>(columns.front().size()); }
};
/// Throws InvalidInput where the budget does not suffice, and Cancelled.
[[nodiscard]] KeptMaterials kept_materials(const CountedMaterials& given, const AttributeLayout& layout,
                                           const AttributeConfig& config, const Progress& progress);
/// A mean as a row of its columns; `to` has one value per column.
void put_mean(const VoxelSample& mean, const AttributeLayout& layout, std::span<std::uint32_t> to);
/// Of voxels that follow each other, as they were given.
[[nodiscard]] SampleSum given_sum(const VoxelAttributes& attributes, std::uint64_t first_voxel,
                                  std::uint64_t voxel_count);
} // namespace tyndall::voxel_dag
