// SPDX-License-Identifier: GPL-3.0-or-later
// What the voxels of a mesh's surface carry: colours, normals and further values of the triangles that set them.
// Differs:  a voxel has the mean of the samples (surface_samples.hpp) of exactly those triangles that set it by the rule,
//           weighted by the area that each has in it. Sums are whole numbers: neither the order of triangles nor the
//           number of threads nor the CPU changes a bit. Colours are added up as light, not as bytes of sRGB's curve.
//           Where normals cancel to less than a quarter (two sides of a thin wall; a wedge below 29 degrees), only those
//           of one side count, the one with more area.
// Bound:    54 ns of a core's time per voxel with colours, 63 with normals, 94 with both and four channels, 370 with a
//           picture (dragon at 4096, on a machine that did much else at the time). Beside what comes out, 16 to 48 bytes
//           per vertex, 16 per triangle and tile, and 32 to 96 per voxel of the tile at work.
#pragma once
#include "image/filtered_texture.hpp"
#include "voxel_dag/snapped_mesh.hpp"
#include "voxel_dag/voxel_attributes.hpp"
#include <memory>
#include <string>

namespace tyndall::voxel_dag {
struct SurfaceMaterial {
    vec3 color = vec3(0.8f); ///< Linear, [0, 1].
    /// In its place, if there is one: filtered over the square that a voxel's side covers along the direction in which
    /// the picture is most minified.
    std::shared_ptr<const FilteredTexture> texture = nullptr;
    /// Of Surface::channels, by their order: [0, 1], or the red of a picture in its place.
    std::array<float, VoxelAttributes::most_channels> channels{1.0f, 1.0f, 1.0f, 1.0f};
    std::array<std::shared_ptr<const FilteredTexture>, VoxelAttributes::most_channels> channel_textures{};
};
struct SurfaceChannel {
    std::string name;
    std::span<const float> values; ///< Per vertex, [0, 1], times the material's; empty: the material's.
};
enum class SurfaceNormals : std::uint8_t {
    None,
    Faces,    ///< Of triangles, by the order of their corners: counter-clockwise as seen from outside.
    Vertices, ///< Interpolated.
};
/// What is not asked for is empty.
struct Surface {
    std::span<const vec3> colors = {}; ///< Per vertex, of sRGB's curve, [0, 1]; times the material's as light.
    std::span<const SurfaceMaterial> materials = {};
    bool has_material_colors = true;                          ///< Else materials give channels alone.
    std::span<const std::uint32_t> material_of_triangle = {}; ///< Empty: all have the first.
    std::span<const vec2> corner_uvs = {}; ///< Three per triangle; (0, 0) is the lower left of a picture.
    SurfaceNormals normals = SurfaceNormals::None;
    std::span<const vec3> vertex_normals = {}; ///< Of any length. Where one is 0, the triangle's stands for it.
    std::vector<SurfaceChannel> channels = {}; ///< At most VoxelAttributes::most_channels.

    [[nodiscard]] bool has_colors() const { return !colors.empty() || (!materials.empty() && has_material_colors); }
    [[nodiscard]] bool is_empty() const { return !has_colors() && normals == SurfaceNormals::None && channels.empty(); }
};

/// Throws InvalidInput, which names the array and its entry.
void require_usable(const Surface& surface, std::size_t vertex_count, std::size_t triangle_count);
/// Of some triangles, in their order, each with three vertices of its own: the arrays, and what refers to them.
struct SubSurface {
    std::vector<vec3> colors, vertex_normals;
    std::vector<std::uint32_t> material_of_triangle;
    std::vector<vec2> corner_uvs;
    std::vector<std::vector<float>> channels;
    Surface surface;
};
[[nodiscard]] SubSurface sub_surface(const Surface& surface, std::span<const uvec3> triangles,
                                     std::span<const std::uint32_t> chosen);

/// Of `leaves`, what voxelize() made of this very mesh with this configuration; its budget holds for voxels and attributes
/// together. Throws InvalidInput, which names the array and its entry, the budget, or a voxel that no triangle sets; and
/// Cancelled.
[[nodiscard]] VoxelAttributes surface_attributes(std::span<const vec3> positions_m, std::span<const uvec3> triangles,
                                                 const VoxelizeConfig& config, const LeafMasks& leaves,
                                                 const Surface& surface, const Progress& progress);
[[nodiscard]] VoxelAttributes surface_attributes(std::span<const dvec3> positions_m, std::span<const uvec3> triangles,
                                                 const VoxelizeConfig& config, const LeafMasks& leaves,
                                                 const Surface& surface, const Progress& progress);
/// Of a mesh that is snapped already; of the configuration, the rule and the budget count.
[[nodiscard]] VoxelAttributes surface_attributes(const SnappedMesh& mesh, const VoxelizeConfig& config,
                                                 const LeafMasks& leaves, const Surface& surface,
                                                 const Progress& progress);
} // namespace tyndall::voxel_dag
