// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/errors.hpp"
#include "voxel_dag/color_palette.hpp"
#include "voxel_dag/material_indices.hpp"
#include "voxel_dag/vox_scene.hpp"
#include <algorithm>
#include <bit>
#include <numeric>

namespace tyndall::voxel_dag::vox {
namespace {
constexpr std::size_t most_colors = 255;
constexpr std::uint32_t model_level = 8; // 2^8 voxels a side
static_assert(most_side == 1u << model_level);

PackedColor packed_color(const ByteColor& color) {
    return static_cast<PackedColor>(color[0]) << 16 | static_cast<PackedColor>(color[1]) << 8 | color[2];
}
/// Palettes have red in the lowest byte.
std::uint32_t palette_color(PackedColor color) { return color >> 16 | (color & 0xff00u) | (color & 0xffu) << 16; }

/// Sets the palette; returns an index per voxel.
std::vector<std::uint32_t> indices_of(std::span<const ByteColor> colors, TooManyColors too_many, File& file,
                                      const Progress& progress) {
    std::vector<PackedColor> entries(colors.size());
    std::ranges::transform(colors, entries.begin(), packed_color);
    MaterialIndices found = material_indices_of(entries, progress);
    require(found.materials.size() <= most_colors || too_many == TooManyColors::Quantize, "there are ",
            found.materials.size(), " colours; a .vox file has ", most_colors,
            ": ask for a palette of so many (quantize)");
    if (found.materials.size() > most_colors) {
        color_palette::Result palette = color_palette::of_size(entries, most_colors, progress);
        found = {.materials = std::move(palette.colors), .indices = std::move(palette.indices)};
    }
    std::ranges::transform(found.materials, file.palette.begin() + 1, palette_color);
    return std::move(found.indices);
}

/// Cells of 2^level voxels a side that have any, by the voxels' order.
std::uint64_t cell_count(const LeafMasks& leaves, std::uint32_t level) {
    std::uint64_t count = 0;
    for (std::size_t brick = 0; brick < leaves.codes.size(); ++brick)
        if (level < leaf_level)
            for (std::uint64_t left = leaves.masks[brick]; left != 0; left >>= 8)
                count += (left & 0xff) != 0;
        else {
            const std::uint32_t shift = 3 * (level - leaf_level);
            count += brick == 0 || leaves.codes[brick] >> shift != leaves.codes[brick - 1] >> shift;
        }
    return count;
}

void require_fitting(const LeafMasks& leaves) {
    constexpr std::uint64_t most_voxels =
        (std::uint64_t{1} << 29) - (1 << 20); // the rest of 2^31 bytes: headers, nodes
    const std::uint64_t voxel_count = leaves.voxel_count();
    std::uint32_t level = 1;
    while (voxel_count > most_voxels && cell_count(leaves, level) > most_voxels)
        ++level;
    require(voxel_count <= most_voxels, "there are ", voxel_count, " voxels; a .vox file has room for ", most_voxels,
            ": a resolution of ", leaves.resolution() >> level, " would fit");
}

/// The model of the bricks from `brick` on that share its cube of most_side; brick then is the first one beyond.
Model next_model(const LeafMasks& leaves, std::span<const std::uint32_t> indices, std::size_t& brick,
                 std::size_t& voxel_number, std::array<std::uint32_t, 3>& lower) {
    constexpr std::uint32_t shift = 3 * (model_level - leaf_level);
    const std::uint64_t cube = leaves.codes[brick] >> shift;
    std::vector<std::pair<Voxel, std::uint8_t>> voxels;
    Voxel upper{};
    lower.fill(~0u);
    for (; brick < leaves.codes.size() && leaves.codes[brick] >> shift == cube; ++brick)
        for (std::uint64_t left = leaves.masks[brick]; left != 0; left &= left - 1, ++voxel_number) {
            const auto bit = static_cast<std::uint64_t>(std::countr_zero(left));
            const Voxel voxel = voxel_at(leaves.codes[brick] << 3 * leaf_level | bit);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                lower[axis] = std::min(lower[axis], voxel[axis]);
                upper[axis] = std::max(upper[axis], voxel[axis]);
            }
            voxels.emplace_back(voxel, static_cast<std::uint8_t>(indices.empty() ? 1 : indices[voxel_number] + 1));
        }
    Model model;
    for (std::size_t axis = 0; axis < 3; ++axis)
        model.sides[axis] = upper[axis] - lower[axis] + 1;
    for (const auto& [voxel, color] : voxels)
        model.voxels.push_back({static_cast<std::uint8_t>(voxel[0] - lower[0]),
                                static_cast<std::uint8_t>(voxel[1] - lower[1]),
                                static_cast<std::uint8_t>(voxel[2] - lower[2]), color});
    return model;
}
} // namespace

File file_of(const LeafMasks& leaves, std::span<const ByteColor> colors, const std::array<std::int64_t, 3>& lower,
             TooManyColors too_many, const Progress& progress) {
    require_usable(leaves);
    require(!leaves.codes.empty(), "there are no voxels, and a .vox file needs one");
    require_fitting(leaves);
    require(colors.empty() || colors.size() == leaves.voxel_count(), colors.size(), " colours for ",
            leaves.voxel_count(), " voxels");
    constexpr std::int64_t farthest = std::int64_t{1} << 30;
    for (const std::int64_t at : lower)
        require(-farthest <= at && at <= farthest, "the cube begins ", at, " voxels from 0, and ", farthest,
                " are possible: move it");
    File file{.models = {}, .nodes = {}, .is_hidden = {}, .palette = default_palette()};
    const std::vector<std::uint32_t> indices = indices_of(colors, too_many, file, progress);
    Node& group = file.nodes[1];
    file.nodes[0] = {.kind = NodeKind::Transform, .translation = {}, .children = {1}};
    std::size_t voxel_number = 0;
    for (std::size_t brick = 0; brick < leaves.codes.size();) {
        progress.poll();
        std::array<std::uint32_t, 3> corner;
        const auto model_number = static_cast<std::int32_t>(file.models.size());
        const Model& model = file.models.emplace_back(next_model(leaves, indices, brick, voxel_number, corner));
        const std::int32_t transform = 2 + 2 * model_number, shape = transform + 1;
        group.children.push_back(transform);
        Node& placing = file.nodes[transform];
        placing = {.kind = NodeKind::Transform, .translation = {}, .children = {shape}};
        for (std::size_t axis = 0; axis < 3; ++axis)
            placing.translation[axis] = static_cast<std::int32_t>(lower[axis] + corner[axis] + model.sides[axis] / 2);
        file.nodes[shape] = {.kind = NodeKind::Shape, .translation = {}, .children = {model_number}};
    }
    return file;
}
} // namespace tyndall::voxel_dag::vox
