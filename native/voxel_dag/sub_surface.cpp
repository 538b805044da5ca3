// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/surface_attributes.hpp"

namespace tyndall::voxel_dag {
template <class Value>
static std::vector<Value> of_corners(std::span<const Value> of_vertices, std::span<const uvec3> triangles,
                                     std::span<const std::uint32_t> chosen) {
    std::vector<Value> values;
    if (of_vertices.empty())
        return values;
    values.reserve(3 * chosen.size());
    for (const std::uint32_t triangle : chosen)
        for (int corner = 0; corner < 3; ++corner)
            values.push_back(of_vertices[triangles[triangle][corner]]);
    return values;
}

SubSurface sub_surface(const Surface& surface, std::span<const uvec3> triangles,
                       std::span<const std::uint32_t> chosen) {
    SubSurface sub;
    sub.colors = of_corners(surface.colors, triangles, chosen);
    sub.vertex_normals = of_corners(surface.vertex_normals, triangles, chosen);
    for (const std::uint32_t triangle : chosen) {
        if (!surface.material_of_triangle.empty())
            sub.material_of_triangle.push_back(surface.material_of_triangle[triangle]);
        if (!surface.corner_uvs.empty())
            for (std::size_t corner = 0; corner < 3; ++corner)
                sub.corner_uvs.push_back(surface.corner_uvs[3 * std::size_t{triangle} + corner]);
    }
    sub.channels.reserve(surface.channels.size());
    sub.surface = {.colors = sub.colors,
                   .materials = surface.materials,
                   .has_material_colors = surface.has_material_colors,
                   .material_of_triangle = sub.material_of_triangle,
                   .corner_uvs = sub.corner_uvs,
                   .normals = surface.normals,
                   .vertex_normals = sub.vertex_normals,
                   .channels = {}};
    for (const SurfaceChannel& channel : surface.channels)
        sub.surface.channels.push_back(
            {channel.name, sub.channels.emplace_back(of_corners(channel.values, triangles, chosen))});
    return sub;
}
} // namespace tyndall::voxel_dag
