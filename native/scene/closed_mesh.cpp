// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/closed_mesh.hpp"
#include <algorithm>
#include <numeric>
#include <tuple>
#include <vector>

namespace tyndall {
bool is_closed(const SharedMeshArrays& arrays) {
    std::vector<std::uint32_t> by_position(arrays.positions.size());
    std::iota(by_position.begin(), by_position.end(), 0u);
    const auto place = [&](std::uint32_t vertex) {
        const vec3& p = arrays.positions[vertex];
        return std::tie(p.x, p.y, p.z);
    };
    std::ranges::sort(by_position, [&](std::uint32_t a, std::uint32_t b) { return place(a) < place(b); });
    std::vector<std::uint32_t> corner(arrays.positions.size());
    for (std::size_t index = 0; index < by_position.size(); ++index) {
        const bool is_same = index > 0 && place(by_position[index]) == place(by_position[index - 1]);
        corner[by_position[index]] = is_same ? corner[by_position[index - 1]] : by_position[index];
    }
    struct Edge {
        std::uint32_t low, high;
        int direction;
    };
    std::vector<Edge> edges;
    edges.reserve(3 * arrays.triangles.size());
    for (const uvec3& triangle : arrays.triangles)
        for (int side = 0; side < 3; ++side) {
            const std::uint32_t a = corner[triangle[side]], b = corner[triangle[(side + 1) % 3]];
            edges.push_back({std::min(a, b), std::max(a, b), a < b ? 1 : a > b ? -1 : 0});
        }
    std::ranges::sort(edges,
                      [](const Edge& a, const Edge& b) { return std::tie(a.low, a.high) < std::tie(b.low, b.high); });
    int balance = 0;
    for (std::size_t index = 0; index < edges.size(); ++index) {
        balance += edges[index].direction;
        const bool is_last = index + 1 == edges.size() || edges[index].low != edges[index + 1].low ||
                             edges[index].high != edges[index + 1].high;
        if (is_last && balance != 0)
            return false;
    }
    return true;
}
} // namespace tyndall
