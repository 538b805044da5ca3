// SPDX-License-Identifier: GPL-3.0-or-later
// Which consecutive entries of an attribute array share a palette: blocks of any length, each with the width of its
// indices. The baseline that benchmarks compare run blocks with.
// Based on: Kol, dissertation, TU Delft 2018, section 2.4.2, Algorithm 1, both phases, exactly: the blocks are those of
//           its text where "largest" is the first of equally large ones, "2^w unique" is at most as many, and
//           the smallest w wins among equal S_w.
// Differs:  no brute force, in two ways. Phase 1 asks for a length only (line 7: 2^w ceil(log2 lambda) + directory
//           entry < length), so that w can be the outer loop, and a recursion at w ends where its longest window is too
//           short: two pointers find the maximal windows, a heap hands them out, longest first, and a window that a
//           block has cut returns to the heap with what is left of it. Phase 2 stops as soon as w alone exceeds the
//           best memory per entry. All of it works on runs of equal values: blocks begin and end where runs do.
// Bound:    12 bytes per run, 8 per different value; O(n) for the windows, O(runs log runs) for the heap.
#pragma once
#include "core/progress.hpp"
#include <cstdint>
#include <span>
#include <vector>

namespace tyndall::voxel_dag::palette_blocks {
struct Config {
    std::uint32_t directory_entry_bits = 72; ///< What one more block costs beside palette and indices, [0, 1024].
};
struct Block {
    std::uint32_t begin;       ///< Its first entry.
    std::uint32_t entry_count; ///< At least 1.
    std::uint32_t index_bits;  ///< Of an entry, [0, 8]: the block has at most 2^index_bits different values.
    bool operator==(const Block&) const = default;
};
/// Blocks in the order of entries, that leave none out. indices are below material_count; at most 2^32 - 1 of them.
/// Throws InvalidInput, which names the first index that is too large, and Cancelled.
[[nodiscard]] std::vector<Block> partition(std::span<const std::uint32_t> indices, std::uint32_t material_count,
                                           const Config& config, const Progress& progress);
} // namespace tyndall::voxel_dag::palette_blocks
