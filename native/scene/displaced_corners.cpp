// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/displaced_corners.hpp"
#include "core/parallel.hpp"

namespace tyndall {
namespace {
/// Of vertices; zero where no renewed triangle is.
std::vector<vec3> mean_normals(std::span<const vec3> positions, std::span<const uvec3> triangles,
                               std::span<const bool> is_renewed, const Progress& progress) {
    std::vector<vec3> of_face(triangles.size());
    parallel_for(triangles.size(), progress, [&](std::size_t index) {
        of_face[index] = is_renewed[index] ? face_normal(positions, triangles[index]) : vec3(0.0f);
    });
    std::vector<dvec3> sums(positions.size(), dvec3(0.0));
    for (std::size_t index = 0; index < triangles.size(); ++index)
        for (int corner = 0; corner < 3; ++corner)
            sums[triangles[index][corner]] += dvec3(of_face[index]);
    std::vector<vec3> normals(positions.size());
    parallel_for(sums.size(), progress,
                 [&](std::size_t vertex) { normals[vertex] = unit_or(sums[vertex], dvec3(0.0)); });
    return normals;
}
} // namespace

std::vector<std::uint32_t> first_corners(std::span<const uvec3> triangles, std::span<const bool> is_moved,
                                         std::size_t vertex_count) {
    constexpr auto none = ~std::uint32_t{0};
    std::vector<std::uint32_t> first(vertex_count, none);
    for (std::size_t index = 0; index < triangles.size(); ++index)
        for (int corner = 0; is_moved[index] && corner < 3; ++corner)
            if (std::uint32_t& known = first[triangles[index][corner]]; known == none)
                known = static_cast<std::uint32_t>(3 * index) + static_cast<std::uint32_t>(corner);
    std::erase(first, none);
    return first;
}

vec3 face_normal(std::span<const vec3> positions, const uvec3& triangle) {
    const vec3 a = positions[triangle[0]];
    return unit_or(glm::cross(positions[triangle[1]] - a, positions[triangle[2]] - a), vec3(0.0f));
}

void renew_normals(std::span<const vec3> positions, std::span<const uvec3> triangles, std::span<const bool> is_renewed,
                   std::span<vec3> corner_normals, const Progress& progress) {
    const std::vector<vec3> mean = mean_normals(positions, triangles, is_renewed, progress);
    std::vector<bool> is_around(positions.size());
    for (std::size_t index = 0; index < triangles.size(); ++index)
        for (int corner = 0; is_renewed[index] && corner < 3; ++corner)
            is_around[triangles[index][corner]] = true;
    parallel_for(triangles.size(), progress, [&](std::size_t index) {
        for (int corner = 0; corner < 3; ++corner) {
            const std::uint32_t vertex = triangles[index][corner];
            vec3& normal = corner_normals[3 * index + static_cast<std::size_t>(corner)];
            if (is_around[vertex] && normal != vec3(0.0f))
                normal = mean[vertex];
        }
    });
}
} // namespace tyndall
