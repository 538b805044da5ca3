// SPDX-License-Identifier: GPL-3.0-or-later
// What a surface has at the corners of its triangles, in fours that surface_samples.hpp adds up.
// Bound:    16 bytes per vertex and four, ready to be read: a corner is asked for by each tile that its triangle meets.
#pragma once
#include "voxel_dag/surface_attributes.hpp"
#include "voxel_dag/surface_samples.hpp"

namespace tyndall::voxel_dag {
/// Which fours there are, and where: first the colour with the weight as its last, which is always there.
struct SurfaceFours {
    static constexpr std::size_t most = 3;
    std::size_t count = 1, normals = 0, channels = 0; ///< 0: there are none.
};
/// Whole numbers that [0, 1] and [-1, 1] become.
inline constexpr float whole_value = 65535, whole_normal = 32767;

class SurfaceValues {
public:
    /// Throws as surface_attributes() does.
    SurfaceValues(const Surface& surface, std::size_t vertex_count, std::span<const uvec3> triangles,
                  const Progress& progress);

    using Corners = std::array<Four, 3>;
    [[nodiscard]] const SurfaceFours& fours() const { return fours_; }
    /// normal: the triangle's. What pictures are multiplied by, where there are any.
    void corners(std::size_t triangle, const vec3& normal, std::array<Corners, SurfaceFours::most>& to) const;
    /// Nothing: there are no materials.
    [[nodiscard]] const SurfaceMaterial* material(std::size_t triangle) const {
        if (surface_.materials.empty())
            return nullptr;
        return &surface_.materials[surface_.material_of_triangle.empty() ? 0 : surface_.material_of_triangle[triangle]];
    }
    [[nodiscard]] std::span<const vec2, 3> uvs(std::size_t triangle) const {
        return surface_.corner_uvs.subspan(3 * triangle).first<3>();
    }
    [[nodiscard]] bool has_vertex_colors() const { return !surface_.colors.empty(); }
    void prefetch(std::size_t triangle) const {
        for (int corner = 0; corner < 3; ++corner)
            __builtin_prefetch(of_vertices_.data() + triangles_[triangle][corner] * per_vertex_);
    }

private:
    Surface surface_;
    std::span<const uvec3> triangles_;
    SurfaceFours fours_;
    std::size_t per_vertex_ = 0;
    bool has_vertex_channels_ = false;
    std::size_t colors_at_ = 0, normals_at_ = 0, channels_at_ = 0; ///< Of a vertex's fours.
    std::vector<Four> of_vertices_;
};
} // namespace tyndall::voxel_dag
