// SPDX-License-Identifier: GPL-3.0-or-later
// The two sets of voxels that attributes are measured on: 0 the Stanford dragon at 4096^3, 1 Sponza-LowPoly at 2048^3, thin.
#pragma once
#include "support/voxel_attributes.hpp"
#include "voxel_dag/voxelize.hpp"

namespace tyndall::bench {
struct AttributedMesh {
    voxel_dag::LeafMasks leaves;
    VoxelAttributes attributes;
};
/// Empty where the mesh is not there.
inline const AttributedMesh& attributed_mesh(std::int64_t mesh) {
    const auto made = [](const std::optional<BareMesh>& bare, std::uint32_t resolution) -> AttributedMesh {
        if (!bare)
            return {};
        AttributedMesh result{.leaves = voxel_dag::voxelize(std::span<const vec3>(bare->positions), bare->triangles,
                                                            {.resolution = resolution}, {})
                                            .leaves,
                              .attributes = {}};
        result.attributes = voxel_attributes(*bare, result.leaves);
        return result;
    };
    if (mesh == 0) {
        static const AttributedMesh dragon = made(load_dragon(), 4096);
        return dragon;
    }
    static const AttributedMesh sponza = made(load_bare_sponza(), 2048);
    return sponza;
}
} // namespace tyndall::bench
