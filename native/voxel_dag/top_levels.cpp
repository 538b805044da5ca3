// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/top_levels.hpp"
#include "core/errors.hpp"
#include "voxel_dag/coarse_cubes.hpp"
#include <algorithm>
#include <bit>

namespace tyndall::voxel_dag {
std::vector<TopLevel> top_levels_of(const PackedDag& dag, const ColorsOfCubes& colors, const TopLevelsConfig& config,
                                    const Progress& progress) {
    std::vector<TopLevel> levels;
    if (dag.is_empty() || config.most_level == 0)
        return levels;
    // Beyond that number the cubes above, a byte each, would be too many.
    CoarseCubes cubes = coarse_cubes(dag, config.most_level, 8 * config.most_bytes, progress);
    std::vector<std::vector<std::uint64_t>> codes(cubes.level); // as levels
    levels.resize(cubes.level);
    if (!codes.empty())
        codes.back() = std::move(cubes.codes);
    for (std::size_t i = levels.size(); i-- > 0;) {
        for (std::uint64_t last = ~std::uint64_t{0}; const std::uint64_t code : codes[i]) {
            if (last != code >> 3) {
                levels[i].child_masks.push_back(0);
                if (i > 0)
                    codes[i - 1].push_back(code >> 3);
                last = code >> 3;
            }
            levels[i].child_masks.back() = static_cast<std::uint8_t>(levels[i].child_masks.back() | 1u << (code & 7));
        }
    }
    std::size_t kept = 0;
    for (std::uint64_t bytes = 0; kept < levels.size(); ++kept) {
        bytes += levels[kept].child_masks.size();
        if (bytes > config.most_bytes)
            break;
        const std::uint32_t side_level = dag.level - static_cast<std::uint32_t>(kept) - 1;
        if (!colors)
            continue;
        std::vector<Voxel> lowest(codes[kept].size());
        std::ranges::transform(codes[kept], lowest.begin(),
                               [&](std::uint64_t code) { return voxel_at(code << 3 * side_level); });
        levels[kept].colors = colors(lowest, side_level);
    }
    levels.resize(kept);
    return levels;
}

LeafMasks voxels_of(std::span<const TopLevel> levels) {
    std::vector<std::uint64_t> codes{0};
    for (const TopLevel& level : levels) {
        require(level.child_masks.size() == codes.size(), "voxel DAG: a topmost level has ", level.child_masks.size(),
                " cubes above it instead of ", codes.size());
        std::vector<std::uint64_t> below;
        for (std::size_t cube = 0; cube < codes.size(); ++cube)
            for (std::uint64_t octant = 0; octant < 8; ++octant)
                if ((level.child_masks[cube] >> octant & 1) != 0)
                    below.push_back(codes[cube] << 3 | octant);
        require(level.colors.empty() || level.colors.size() == below.size(), "voxel DAG: a topmost level has ",
                level.colors.size(), " colours for ", below.size(), " cubes");
        codes = std::move(below);
    }
    LeafMasks voxels{.level = static_cast<std::uint32_t>(levels.size()), .codes = {}, .masks = {}};
    for (const std::uint64_t code : codes) {
        if (voxels.codes.empty() || voxels.codes.back() != code >> 6) {
            voxels.codes.push_back(code >> 6);
            voxels.masks.push_back(0);
        }
        voxels.masks.back() |= std::uint64_t{1} << (code & 63);
    }
    require_usable(voxels);
    return voxels;
}

void require_top_of(const PackedDag& dag, std::span<const TopLevel> levels, const Progress& progress) {
    std::uint64_t bytes = 0;
    for (const TopLevel& level : levels)
        bytes += level.child_masks.size();
    const std::vector<TopLevel> due = top_levels_of(
        dag, {}, {.most_level = static_cast<std::uint32_t>(levels.size()), .most_bytes = bytes}, progress);
    for (std::size_t i = 0; i < levels.size(); ++i) {
        require(i < due.size() && levels[i].child_masks == due[i].child_masks, "voxel DAG: topmost level ", i + 1,
                " has not the cubes of the records");
        std::size_t cubes = 0;
        for (const std::uint8_t mask : due[i].child_masks)
            cubes += static_cast<std::size_t>(std::popcount(mask));
        require(levels[i].colors.empty() || levels[i].colors.size() == cubes, "voxel DAG: topmost level ", i + 1,
                " has ", levels[i].colors.size(), " colours for ", cubes, " cubes");
    }
}
} // namespace tyndall::voxel_dag
