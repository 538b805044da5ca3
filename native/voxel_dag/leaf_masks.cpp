// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/leaf_masks.hpp"
#include "core/errors.hpp"
#include <algorithm>
#include <bit>

namespace tyndall::voxel_dag {
static void require_level(std::uint32_t level) {
    require(leaf_level <= level && level <= most_level, "voxels: 2^", level, " a side; from 2^", leaf_level, " to 2^",
            most_level, " are possible");
}

std::uint64_t LeafMasks::voxel_count() const {
    std::uint64_t count = 0;
    for (const std::uint64_t mask : masks)
        count += static_cast<std::uint64_t>(std::popcount(mask));
    return count;
}

bool LeafMasks::contains(const Voxel& voxel) const {
    if (std::ranges::any_of(voxel, [&](std::uint32_t at) { return at >= resolution(); }))
        return false;
    const std::uint64_t code = morton_code(voxel);
    const auto found = std::ranges::lower_bound(codes, code >> 3 * leaf_level);
    if (found == codes.end() || *found != code >> 3 * leaf_level)
        return false;
    return (masks[static_cast<std::size_t>(found - codes.begin())] >> (code & 63) & 1) != 0;
}

void require_usable(const LeafMasks& leaves) {
    require_level(leaves.level);
    require(leaves.codes.size() == leaves.masks.size(), "voxels: ", leaves.codes.size(), " bricks have codes, but ",
            leaves.masks.size(), " have masks");
    const std::uint64_t code_count = std::uint64_t{1} << 3 * (leaves.level - leaf_level);
    for (std::size_t brick = 0; brick < leaves.codes.size(); ++brick) {
        require(leaves.masks[brick] != 0, "voxels: brick ", brick, " is empty");
        require(leaves.codes[brick] < code_count, "voxels: brick ", brick, " lies outside of the cube");
        require(brick == 0 || leaves.codes[brick - 1] < leaves.codes[brick], "voxels: brick ", brick,
                " does not follow the one before it in Morton order");
    }
}

LeafMasks leaf_masks_of(std::vector<Voxel> voxels, std::uint32_t level) {
    require_level(level);
    LeafMasks leaves{.level = level, .codes = {}, .masks = {}};
    for (const Voxel& voxel : voxels)
        require(std::ranges::all_of(voxel, [&](std::uint32_t at) { return at < leaves.resolution(); }), "voxel (",
                voxel[0], ", ", voxel[1], ", ", voxel[2], ") lies beyond the resolution, ", leaves.resolution());
    std::ranges::sort(voxels, {}, morton_code);
    for (const Voxel& voxel : voxels) {
        const std::uint64_t code = morton_code(voxel);
        if (leaves.codes.empty() || leaves.codes.back() != code >> 3 * leaf_level) {
            leaves.codes.push_back(code >> 3 * leaf_level);
            leaves.masks.push_back(0);
        }
        leaves.masks.back() |= std::uint64_t{1} << (code & 63);
    }
    return leaves;
}
} // namespace tyndall::voxel_dag
