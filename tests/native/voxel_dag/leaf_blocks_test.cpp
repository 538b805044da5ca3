// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/errors.hpp"
#include "support/voxel_sets.hpp"
#include "voxel_dag/leaf_blocks.hpp"
#include <doctest/doctest.h>

namespace leaf_blocks_test {
using namespace tyndall;
using namespace tyndall::voxel_dag;
using namespace tyndall::support;

static const Progress progress;

// Seen to fail with y and z exchanged.
TEST_CASE("bit 8 y + z of word x of a block is the voxel there, and blocks in any order give the voxels back") {
    for (const LeafMasks& leaves :
         {random_voxels(3, 0.2, 1), random_voxels(5, 0.02, 2), random_voxels(6, 0.5, 3),
          sphere_voxels(7, {60, 64, 70}, 50), full_voxels(4), LeafMasks{.level = 9, .codes = {}, .masks = {}}}) {
        LeafBlocks blocks = leaf_blocks_of(leaves, progress);
        std::uint64_t set_count = 0;
        for (std::size_t block = 0; block < blocks.origins.size(); ++block)
            for (std::uint32_t x = 0; x < 8; ++x)
                for (std::uint32_t y = 0; y < 8; ++y)
                    for (std::uint32_t z = 0; z < 8; ++z) {
                        const auto& [x0, y0, z0] = blocks.origins[block];
                        const bool is_set = (blocks.bits[block][x] >> (8 * y + z) & 1) != 0;
                        REQUIRE(is_set == leaves.contains({x0 + x, y0 + y, z0 + z}));
                        set_count += is_set;
                    }
        CHECK(set_count == leaves.voxel_count());
        std::ranges::reverse(blocks.origins), std::ranges::reverse(blocks.bits);
        CHECK(leaf_masks_of(blocks.origins, blocks.bits, leaves.level, progress) == leaves);
    }
}

TEST_CASE("a block in a wrong place is named, and an empty one leaves nothing") {
    const auto refusal = [](const std::vector<Voxel>& origins) {
        try {
            const std::vector<BlockBits> bits(origins.size());
            const LeafMasks leaves = leaf_masks_of(origins, bits, 5, progress);
            CHECK(leaves.codes.empty());
        } catch (const InvalidInput& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    CHECK(refusal({{0, 0, 0}, {8, 16, 24}}) == "");
    CHECK(refusal({{0, 0, 0}, {8, 4, 24}}).find("block 1 begins at (8, 4, 24)") != std::string::npos);
    CHECK(refusal({{32, 0, 0}}).find("block 0 begins at (32, 0, 0)") != std::string::npos);
    CHECK(refusal({{8, 0, 0}, {0, 0, 0}, {8, 0, 0}}).find("lie in one place") != std::string::npos);
}
} // namespace leaf_blocks_test
