// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/leaf_blocks.hpp"
#include "core/parallel.hpp"
#include <algorithm>
#include <numeric>

namespace tyndall::voxel_dag {
namespace {
constexpr std::size_t blocks_at_once = 256;

/// Where the voxel of Morton code i in octant 0 of a block is: bit of word. Octants add to both.
struct BitPlace {
    std::uint32_t word, bit;
};
constexpr BitPlace place_of(std::uint32_t octant, std::uint32_t code) {
    const Voxel voxel = voxel_at(octant << 3 * leaf_level | code);
    return {voxel[0], 8 * voxel[1] + voxel[2]};
}
using Places = std::array<std::array<BitPlace, 64>, 8>;
constexpr Places make_places() {
    Places bit_places{};
    for (std::uint32_t octant = 0; octant < 8; ++octant)
        for (std::uint32_t code = 0; code < 64; ++code)
            bit_places[octant][code] = place_of(octant, code);
    return bit_places;
}
constexpr Places bit_places = make_places();

/// The block's bricks, by octant.
std::array<std::uint64_t, 8> bricks_of(const BlockBits& bits) {
    std::array<std::uint64_t, 8> bricks{};
    if (std::ranges::all_of(bits, [](std::uint64_t word) { return word == 0; }))
        return bricks;
    for (std::size_t octant = 0; octant < 8; ++octant)
        for (std::size_t code = 0; code < 64; ++code) {
            const auto [word, bit] = bit_places[octant][code];
            bricks[octant] |= (bits[word] >> bit & 1) << code;
        }
    return bricks;
}
} // namespace

LeafMasks leaf_masks_of(std::span<const Voxel> origins, std::span<const BlockBits> bits, std::uint32_t level,
                        const Progress& progress) {
    require(block_level <= level && level <= most_level, "voxels: 2^", level, " a side; from 2^", block_level, " to 2^",
            most_level, " are possible");
    require(origins.size() == bits.size(), "voxels: ", origins.size(), " blocks have origins, but ", bits.size(),
            " have bits");
    std::vector<std::uint64_t> codes(origins.size());
    for (std::size_t block = 0; block < origins.size(); ++block) {
        const auto& [x, y, z] = origins[block];
        require(((x | y | z) & 7u) == 0 && (x | y | z) >> level == 0, "voxels: block ", block, " begins at (", x, ", ",
                y, ", ", z, "), no multiple of 8 in a cube of ", 1u << level);
        codes[block] = morton_code(origins[block]) >> 3 * block_level;
    }
    std::vector<std::uint32_t> order(origins.size());
    std::iota(order.begin(), order.end(), 0u);
    std::ranges::sort(order, {}, [&](std::uint32_t block) { return codes[block]; });
    for (std::size_t i = 1; i < order.size(); ++i)
        require(codes[order[i - 1]] != codes[order[i]], "voxels: blocks ", order[i - 1], " and ", order[i],
                " lie in one place");
    std::vector<std::array<std::uint64_t, 8>> bricks(origins.size());
    parallel_for(
        order.size(), progress, [&](std::size_t i) { bricks[i] = bricks_of(bits[order[i]]); }, blocks_at_once);
    LeafMasks leaves{.level = level, .codes = {}, .masks = {}};
    for (std::size_t i = 0; i < order.size(); ++i)
        for (std::uint64_t octant = 0; octant < 8; ++octant)
            if (bricks[i][octant] != 0) {
                leaves.codes.push_back(codes[order[i]] << 3 | octant);
                leaves.masks.push_back(bricks[i][octant]);
            }
    return leaves;
}

LeafBlocks leaf_blocks_of(const LeafMasks& leaves, const Progress& progress) {
    std::vector<std::size_t> first_bricks; // of each block, and one past
    for (std::size_t brick = 0; brick < leaves.codes.size(); ++brick)
        if (brick == 0 || leaves.codes[brick] >> 3 != leaves.codes[brick - 1] >> 3)
            first_bricks.push_back(brick);
    LeafBlocks blocks{.origins = std::vector<Voxel>(first_bricks.size()),
                      .bits = std::vector<BlockBits>(first_bricks.size())};
    first_bricks.push_back(leaves.codes.size());
    parallel_for(
        blocks.origins.size(), progress,
        [&](std::size_t block) {
            blocks.origins[block] = voxel_at(leaves.codes[first_bricks[block]] >> 3 << 3 * block_level);
            for (std::size_t brick = first_bricks[block]; brick < first_bricks[block + 1]; ++brick)
                for (std::uint64_t left = leaves.masks[brick]; left != 0; left &= left - 1) {
                    const auto [word, bit] =
                        bit_places[leaves.codes[brick] & 7][static_cast<std::size_t>(std::countr_zero(left))];
                    blocks.bits[block][word] |= std::uint64_t{1} << bit;
                }
        },
        blocks_at_once);
    return blocks;
}
} // namespace tyndall::voxel_dag
