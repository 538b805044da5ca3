// SPDX-License-Identifier: GPL-3.0-or-later
// MagicaVoxel's models and the graph that places them become voxels with colours, and voxels become models.
// Based on: MagicaVoxel-file-format-vox-extension.txt: a model is turned about the corner floor(side / 2) of its voxels,
//           which then lies where the transforms above it have moved 0.
// Bound:    reading, 192 bytes per brick of 4^3 that has any; models one after the other, where they overlap the later one in
//           the graph counts. 33.6 M voxels of two models take 2.2 s of one core's time, the file, the graph and the colours
//           that are packed of them included. Writing, 4 bytes per voxel in the file and 12 beside it.
#pragma once
#include "voxel_dag/leaf_masks.hpp"
#include "voxel_dag/vox_file.hpp"
#include "voxel_dag/voxel_attributes.hpp"
#include "voxel_dag/voxelize.hpp"

namespace tyndall::voxel_dag::vox {
struct Config {
    std::uint64_t memory_budget_bytes = std::uint64_t{4} << 30; ///< A small file can place a model a million times.
};
struct SceneVoxels {
    LeafMasks leaves;                    ///< Of the smallest cube that holds what is shown.
    std::array<std::int64_t, 3> lower{}; ///< The cube's lowest voxel, by the file's coordinates.
    /// Colours; channels "roughness", "metallic" and "emission" where a voxel has another than 1, 0 and 0.
    VoxelAttributes attributes;
};
/// What is hidden, or in a hidden layer, is left out. A file without a graph, as old versions wrote it, has frames one
/// after the other: its first model, from 0 on. Throws InvalidInput (nodes that are not there or go in circles, more than
/// 2^most_level voxels a side, a budget that does not suffice) and Cancelled.
[[nodiscard]] SceneVoxels voxels_of(const File& file, const Config& config, const Progress& progress);

enum class TooManyColors : std::uint8_t {
    Refuse,   ///< More than 255 are an InvalidInput.
    Quantize, ///< See color_palette.hpp.
};
/// Models of most_side a side, and a graph that puts them together. `colors`: one per voxel in Morton order, or none.
/// Throws InvalidInput (colours; more than 2^31 bytes, and what would fit; `lower` beyond 2^30) and Cancelled.
[[nodiscard]] File file_of(const LeafMasks& leaves, std::span<const ByteColor> colors,
                           const std::array<std::int64_t, 3>& lower, TooManyColors too_many, const Progress& progress);

/// In metres, and from and to a path, which messages begin with.
struct PlacedVoxels {
    LeafMasks leaves;
    VoxelAttributes attributes;
    Cube bounds_m;
};
/// Throws InvalidInput as voxels_of() does, and for a size that is no length; IoError, which names the chunk that is
/// damaged; and Cancelled.
[[nodiscard]] PlacedVoxels read_placed(const std::filesystem::path& path, double voxel_size_m, const Config& config,
                                       const Progress& progress);
/// Voxels lie on whole numbers of their size: the cube's lowest corner is rounded to one. Throws InvalidInput as
/// file_of() does, IoError and Cancelled.
void write_placed(const LeafMasks& leaves, std::span<const ByteColor> colors, const Cube& bounds_m,
                  TooManyColors too_many, const std::filesystem::path& path, const Progress& progress);
} // namespace tyndall::voxel_dag::vox
