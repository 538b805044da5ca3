// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/coarse_voxels.hpp"
#include "core/errors.hpp"
#include "voxel_dag/decode.hpp"

namespace tyndall::voxel_dag {
namespace {
LeafMasks none_at(std::uint32_t fine_level, std::uint32_t level) {
    require(level <= fine_level - leaf_level, "level is ", level, ", but of cubes of 2^", level,
            " voxels a side there are fewer than ", 1u << leaf_level, " in a resolution of ",
            std::uint64_t{1} << fine_level);
    return {.level = fine_level - level, .codes = {}, .masks = {}};
}

/// A cube of 4^3, which may be that of the one before it.
void add_cube(std::uint64_t code, LeafMasks& coarse) {
    if (coarse.codes.empty() || coarse.codes.back() != code >> 3 * leaf_level) {
        coarse.codes.push_back(code >> 3 * leaf_level);
        coarse.masks.push_back(0);
    }
    coarse.masks.back() |= std::uint64_t{1} << (code & 63);
}
void append(const LeafMasks& leaves, std::uint32_t level, LeafMasks& coarse) {
    if (level == 0) {
        coarse.codes.insert(coarse.codes.end(), leaves.codes.begin(), leaves.codes.end());
        coarse.masks.insert(coarse.masks.end(), leaves.masks.begin(), leaves.masks.end());
        return;
    }
    for (std::size_t brick = 0; brick < leaves.codes.size(); ++brick)
        if (level >= leaf_level)
            add_cube(leaves.codes[brick] >> 3 * (level - leaf_level), coarse);
        else
            for (std::uint64_t octant = 0; octant < 8; ++octant)
                if ((leaves.masks[brick] >> 8 * octant & 0xff) != 0)
                    add_cube(leaves.codes[brick] << 3 | octant, coarse);
}
} // namespace

LeafMasks coarse_voxels(const LeafMasks& leaves, std::uint32_t level) {
    LeafMasks coarse = none_at(leaves.level, level);
    append(leaves, level, coarse);
    return coarse;
}

LeafMasks coarse_voxels(const PackedDag& dag, std::uint32_t level, std::uint64_t memory_budget_bytes,
                        const Progress& progress) {
    constexpr std::size_t bricks_at_once = 1 << 16;
    constexpr std::uint64_t brick_bytes = 2 * sizeof(std::uint64_t);
    LeafMasks coarse = none_at(dag.level, level);
    decode(
        dag, bricks_at_once,
        [&](const LeafMasks& part) {
            append(part, level, coarse);
            require(coarse.codes.size() * brick_bytes <= memory_budget_bytes, "the DAG's ", dag.voxel_count,
                    " voxels take more than the memory budget, ", memory_budget_bytes,
                    " bytes, when they are unpacked: choose a coarser level, or raise the budget");
        },
        progress);
    return coarse;
}
} // namespace tyndall::voxel_dag
