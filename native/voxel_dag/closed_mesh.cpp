// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/closed_mesh.hpp"
#include <algorithm>
#include <numeric>

namespace tyndall::voxel_dag {
/// Of each vertex the least one at the same place.
static std::vector<std::uint32_t> place_of_vertices(const SnappedMesh& mesh) {
    std::vector<std::uint32_t> order(mesh.positions.size()), place(mesh.positions.size());
    std::iota(order.begin(), order.end(), 0u);
    std::ranges::sort(order, {}, [&](std::uint32_t vertex) { return std::pair(mesh.positions[vertex], vertex); });
    for (std::size_t i = 0; i < order.size(); ++i) {
        const bool is_same = i > 0 && mesh.positions[order[i]] == mesh.positions[order[i - 1]];
        place[order[i]] = is_same ? place[order[i - 1]] : order[i];
    }
    return place;
}

std::optional<OpenEdge> open_edge(const SnappedMesh& mesh, const Progress& progress) {
    struct Edge {
        std::uint64_t ends; ///< The lesser one above the other.
        std::uint32_t triangle;
        std::int8_t corner, way;
    };
    const std::vector<std::uint32_t> place = place_of_vertices(mesh);
    progress.poll();
    std::vector<Edge> edges;
    edges.reserve(3 * mesh.triangles.size());
    for (std::size_t triangle = 0; triangle < mesh.triangles.size(); ++triangle)
        for (int corner = 0; corner < 3; ++corner) {
            const std::uint64_t from = place[mesh.triangles[triangle][corner]],
                                to = place[mesh.triangles[triangle][(corner + 1) % 3]];
            if (from != to)
                edges.push_back({std::min(from, to) << 32 | std::max(from, to), static_cast<std::uint32_t>(triangle),
                                 static_cast<std::int8_t>(corner), static_cast<std::int8_t>(from < to ? 1 : -1)});
        }
    progress.poll();
    std::ranges::sort(edges, {}, [](const Edge& edge) { return std::pair(edge.ends, edge.triangle); });
    std::optional<OpenEdge> first;
    for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
        std::int64_t ways = 0;
        for (; end < edges.size() && edges[end].ends == edges[begin].ends; ++end)
            ways += edges[end].way;
        if (ways != 0 && (!first || edges[begin].triangle < first->triangle))
            first = OpenEdge{edges[begin].triangle, edges[begin].corner};
    }
    return first;
}
} // namespace tyndall::voxel_dag
