// SPDX-License-Identifier: GPL-3.0-or-later
// Random triangle soups: occluders without any structure that a method could lean on.
#pragma once
#include "support/forest.hpp"
#include "support/scenes.hpp"

namespace tyndall::support {
/// Triangles with corners up to `size_m` from centres spread over the box.
inline std::shared_ptr<const TriangleMesh> soup_mesh(std::size_t triangle_count, const Bounds3& box, float size_m,
                                                     std::uint64_t seed) {
    SceneRandom random(seed);
    MeshArrays arrays;
    arrays.name = "soup";
    for (std::size_t triangle = 0; triangle < triangle_count; ++triangle) {
        const vec3 share(random.uniform(), random.uniform(), random.uniform());
        const vec3 centre = box.min + share * (box.max - box.min);
        const auto first = static_cast<std::uint32_t>(arrays.positions.size());
        for (int corner = 0; corner < 3; ++corner)
            arrays.positions.push_back(centre + size_m * random.uniform() * random.direction());
        arrays.triangles.emplace_back(first, first + 1, first + 2);
    }
    return mesh_of(std::move(arrays));
}
} // namespace tyndall::support
