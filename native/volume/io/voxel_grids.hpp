// SPDX-License-Identifier: GPL-3.0-or-later
// Voxels that are set or not as OpenVDB's grids: fog volumes of 1, level sets, and smooth meshes of these.
// Based on: Museth, VDB, ACM TOG 32(3), 2013; OpenVDB's topologyToLevelSet and volumeToMesh (dual contouring).
// Bound:    2.1 KB per leaf that is not full of voxels or empty; a level set has three voxels more on either side.
#pragma once
#include "volume/io/vdb_file.hpp"
#include <optional>

namespace tyndall::volume_io {
/// Leaves of 8 x 8 x 8, in any order.
struct VoxelBits {
    std::span<const VoxelIndex> leaf_origins{};  ///< Multiples of 8, each once.
    std::span<const std::uint64_t> leaf_words{}; ///< 8 per leaf: bit 8 y + z of word x.
    Matrix local_from_index{};                   ///< A voxel's centre has its index.
};
enum class VoxelGridKind : std::uint8_t {
    Fog,      ///< 1 where a voxel is set, 0 elsewhere.
    LevelSet, ///< Distance to the voxels' faces, smoothed by its own gradient; negative where a voxel is set.
};
/// A grid of three numbers, 0 where no voxel is set.
struct VoxelColors {
    std::string name;
    std::span<const std::array<float, 3>> linear{}; ///< Of each voxel that is set: leaf by leaf, x slowest, z fastest.
};
/// One grid, and one of colours, if there are any. Throws IoError and InvalidInput, which name path and grid, and Cancelled.
void write_voxels(const std::filesystem::path& path, const std::string& name, const VoxelBits& voxels,
                  VoxelGridKind kind, const std::optional<VoxelColors>& colors, const Metadata& metadata,
                  const Progress& progress);

struct SmoothMesh {
    std::vector<std::array<float, 3>> positions;         ///< By index: voxel (x, y, z) has its centre there.
    std::vector<std::array<std::uint32_t, 3>> triangles; ///< Seen from outside, corners go round against the clock.
};
/// The level set's surface. Its points lie within a voxel of the voxels' faces. Throws InvalidInput, Cancelled.
[[nodiscard]] SmoothMesh smooth_mesh_of(const VoxelBits& voxels, const Progress& progress);
} // namespace tyndall::volume_io
