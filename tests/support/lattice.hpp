// SPDX-License-Identifier: GPL-3.0-or-later
// An occluder whose shafts no view ray runs along for long: a lattice of crossed bars.
#pragma once
#include "scene/triangle_mesh.hpp"

namespace tyndall::support {
/// Bars 4 cm wide, 10 cm apart, over the square [-2, 2]^2 in the plane z = 0.
inline MeshArrays lattice() {
    MeshArrays mesh{.name = "lattice"};
    const auto add_bar = [&](const vec3& low, const vec3& high) {
        const auto first = static_cast<std::uint32_t>(mesh.positions.size());
        mesh.positions.insert(mesh.positions.end(),
                              {low, vec3(high.x, low.y, low.z), high, vec3(low.x, high.y, high.z)});
        mesh.triangles.insert(mesh.triangles.end(),
                              {uvec3(first, first + 1, first + 2), uvec3(first, first + 2, first + 3)});
    };
    for (int bar = 0; bar < 30; ++bar) {
        const float at = -2.0f + 0.14f * static_cast<float>(bar);
        add_bar({at, -2, 0}, {at + 0.04f, 2, 0});
        add_bar({-2, at, 0}, {2, at + 0.04f, 0});
    }
    return mesh;
}
} // namespace tyndall::support
