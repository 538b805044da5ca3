// SPDX-License-Identifier: GPL-3.0-or-later
// Sets of voxels as packed DAGs, and one by one, for tests and benchmarks.
#pragma once
#include "voxel_dag/build_dag.hpp"
#include "voxel_dag/merge_symmetric.hpp"
#include "voxel_dag/pack_dag.hpp"

namespace tyndall::support {
inline constexpr std::array all_symmetries{voxel_dag::Symmetry::None, voxel_dag::Symmetry::Reflections,
                                           voxel_dag::Symmetry::Cube};

inline voxel_dag::PackedDag packed(const voxel_dag::LeafMasks& voxels, voxel_dag::Symmetry symmetry) {
    const Progress progress;
    voxel_dag::Dag dag = voxel_dag::build_dag(voxels, {}, progress);
    if (symmetry != voxel_dag::Symmetry::None)
        dag = voxel_dag::merge_symmetric(dag, {.symmetry = symmetry}, progress);
    return voxel_dag::pack_dag(dag, progress);
}

/// In Morton order.
inline std::vector<voxel_dag::Voxel> listed(const voxel_dag::LeafMasks& voxels) {
    std::vector<voxel_dag::Voxel> list;
    for (std::size_t brick = 0; brick < voxels.codes.size(); ++brick)
        for (std::uint64_t left = voxels.masks[brick]; left != 0; left &= left - 1)
            list.push_back(
                voxel_dag::voxel_at(voxels.codes[brick] << 6 | static_cast<std::uint32_t>(std::countr_zero(left))));
    return list;
}
} // namespace tyndall::support
