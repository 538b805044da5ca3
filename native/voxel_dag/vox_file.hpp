// SPDX-License-Identifier: GPL-3.0-or-later
// MagicaVoxel's .vox files as they lie: models of at most 256 voxels a side with indices of one palette, and the graph that
// places them. What the graph makes of them: vox_scene.hpp.
// Based on: MagicaVoxel-file-format-vox.txt and -vox-extension.txt, github.com/ephtracy/voxel-model.
// Differs:  IMAP is checked and passed over: it says in which order MagicaVoxel shows the palette, and no voxel's colour
//           depends on that. PACK, MATT, rOBJ, rCAM and NOTE are passed over, as is what came later.
// Bound:    the file once in memory, and 4 bytes per voxel of it.
#pragma once
#include "core/progress.hpp"
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <vector>

namespace tyndall::voxel_dag::vox {
inline constexpr std::uint32_t most_side = 256; ///< Of a model: its coordinates are bytes.

struct ModelVoxel {
    std::uint8_t x, y, z; ///< Below the model's sides; z is up.
    std::uint8_t color;   ///< In the palette, [1, 255].

    bool operator==(const ModelVoxel&) const = default;
};
struct Model {
    std::array<std::uint32_t, 3> sides{}; ///< Each in [1, most_side].
    std::vector<ModelVoxel> voxels;       ///< Where two lie in one place, the later counts.

    bool operator==(const Model&) const = default;
};
enum class NodeKind : std::uint8_t { Transform, Group, Shape };
struct Node {
    static constexpr std::uint8_t no_rotation = 0 | 1 << 2;

    NodeKind kind = NodeKind::Group;
    bool is_hidden = false;
    std::int32_t layer = -1; ///< Of a transform; -1: none.
    /// Of a transform, in its first frame. Bits 0 and 1: the column of the 1 in the matrix's first row; 2 and 3: in its
    /// second; 4, 5 and 6: the row's 1 is -1.
    std::uint8_t rotation = no_rotation;
    std::array<std::int32_t, 3> translation{};
    std::vector<std::int32_t> children; ///< One of a transform. Of a shape: its first frame's model.

    bool operator==(const Node&) const = default;
};
/// What MATL says of a palette's index. 255 is 1.
struct Material {
    std::uint8_t roughness = 255, metallic = 0, emission = 0;

    bool operator==(const Material&) const = default;
};
struct File {
    std::vector<Model> models;
    std::map<std::int32_t, Node> nodes;       ///< Node 0 is the root; none: an old file, one model after the other.
    std::map<std::int32_t, bool> is_hidden;   ///< Layers.
    std::array<std::uint32_t, 256> palette{}; ///< Of sRGB's curve: r + 2^8 g + 2^16 b. Index 0 is never used.
    std::array<Material, 256> materials{};

    bool operator==(const File&) const = default;
};
/// MagicaVoxel's own, for files without one.
[[nodiscard]] std::array<std::uint32_t, 256> default_palette();

/// Throws InvalidInput, which names the first chunk that is damaged, by its name and place, and Cancelled. Nodes that are
/// not there, or go in circles, are left to vox_scene.hpp.
[[nodiscard]] File parse(std::span<const std::uint8_t> bytes, const Progress& progress);
/// Nodes, models and palette; materials and layers are left out. Throws Cancelled.
[[nodiscard]] std::vector<std::uint8_t> to_bytes(const File& file, const Progress& progress);

/// Throws IoError, which names the path and the chunk that is damaged, and Cancelled.
[[nodiscard]] File read(const std::filesystem::path& path, const Progress& progress);
/// The file appears whole or not at all. Throws IoError, which names the path and why, and Cancelled.
void write(const File& file, const std::filesystem::path& path, const Progress& progress);
} // namespace tyndall::voxel_dag::vox
