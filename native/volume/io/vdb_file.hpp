// SPDX-License-Identifier: GPL-3.0-or-later
// OpenVDB files in and out, as leaves of 8 x 8 x 8 floats. OpenVDB itself is included nowhere else, and none of its types
// leaves this folder: its headers cost seconds per file, and Blender holds another OpenVDB in the same process.
// Differs:  openvdb::io::File neither notices that a file ends early nor that a disk is full, and reads and writes a grid
//           in one piece. The streams here throw on both and poll Progress at every block.
// Bound:    while a grid is read, its tree and its leaves are in memory at once.
#pragma once
#include "core/progress.hpp"
#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tyndall::volume_io {
constexpr std::size_t voxels_per_leaf = 512; ///< 8 x 8 x 8, z fastest.

using VoxelIndex = std::array<std::int32_t, 3>; ///< x, y, z
using Matrix = std::array<double, 16>;          ///< Row by row, for column vectors.
using Metadata = std::map<std::string, std::string>;

/// What a file says of a grid without reading its voxels.
struct GridInfo {
    std::string name;                       ///< "density"; "density[1]" is the second one of this name.
    std::string value_type;                 ///< OpenVDB's: "float", "double", "int32", "bool", "vec3s", ...
    std::string grid_class;                 ///< "fog volume", "level set", "staggered", "unknown".
    bool is_half = false;                   ///< Real numbers are stored with 16 bits.
    std::uint64_t active_voxel_count = 0;   ///< Those of active tiles included.
    VoxelIndex first_index{}, last_index{}; ///< Bounds of the active voxels, both inclusive; last below first: none.
    std::optional<Matrix> local_from_index; ///< Nothing: the grid lies in a frustum.
    std::string refusal;                    ///< Why read() would refuse it; empty if it would not.
};
struct FileInfo {
    std::vector<GridInfo> grids; ///< In the order of the file.
    Metadata metadata;           ///< Of the file, as text.
};

/// A scalar grid. Voxels outside of its leaves have the background's value.
struct Grid {
    std::string name;
    std::vector<VoxelIndex> leaf_origins; ///< First voxel of each leaf, multiples of 8, ascending by x, y, z.
    std::vector<float> leaf_values;       ///< voxels_per_leaf per leaf, those that are not active included.
    Matrix local_from_index{};            ///< A voxel's centre has its index.
    float background = 0.0f;
};
/// The same, of arrays that belong to the caller; leaves in any order.
struct GridView {
    std::string name;
    std::span<const VoxelIndex> leaf_origins{};
    std::span<const float> leaf_values{};
    Matrix local_from_index{};
    float background = 0.0f;
};
enum class Precision : std::uint8_t { Float, Half };

/// Throws IoError that names the path, and the grid that is damaged, and Cancelled; so do the other two.
[[nodiscard]] FileInfo list(const std::filesystem::path& path, const Progress& progress);

/// The grids of these names, or all that can be read, in the order of the file. Numbers of any type become floats; a grid
/// of vectors becomes three, "name.x", "name.y" and "name.z". Constant tiles become leaves. Throws InvalidInput for a name
/// that the file does not have, a grid of another kind, and leaves that would need more memory than the limit.
[[nodiscard]] std::vector<Grid> read(const std::filesystem::path& path,
                                     const std::optional<std::vector<std::string>>& names,
                                     std::size_t memory_limit_bytes, Progress& progress);

/// Fog volumes, compressed without loss (Blosc); voxels whose bits are not the background's are active. Half keeps 11 bits.
/// Matrices are exact, but OpenVDB takes scales that differ by less than 1e-15 for the same.
/// The file's metadata; its entry "creator" becomes the grids' as well. Throws InvalidInput that names the grid.
void write(const std::filesystem::path& path, std::span<const GridView> grids, Precision precision,
           const Metadata& metadata, Progress& progress);

/// "10.0.1"
[[nodiscard]] std::string library_version();
} // namespace tyndall::volume_io
