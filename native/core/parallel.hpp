// SPDX-License-Identifier: GPL-3.0-or-later
// Parallel loops whose results do not depend on the number of threads: work is cut into blocks by size, never by
// thread, and a block's result belongs to the block.
// Differs from tbb::parallel_for: polls Progress before each block, and reductions add block by block in order.
#pragma once
#include "core/progress.hpp"
#include <algorithm>
#include <cstddef>
#include <tbb/blocked_range.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <vector>

namespace tyndall {
/// Runs work inside an arena of at most `thread_count` threads; 0 means all cores. Never tbb::global_control: where TBB is shared
/// with Blender, that throttles Blender, too.
template <typename Work>
auto with_threads(int thread_count, Work&& work) {
    // TBB prints a warning when it is asked for more threads than there are cores.
    const int core_count = tbb::info::default_concurrency();
    tbb::task_arena arena(thread_count > 0 ? std::min(thread_count, core_count) : tbb::task_arena::automatic);
    return arena.execute(std::forward<Work>(work));
}

/// work(begin, end) for consecutive blocks of at most block_size; throws Cancelled soon after progress.cancel().
template <typename Work>
void parallel_blocks(std::size_t count, std::size_t block_size, const Progress& progress, const Work& work) {
    const std::size_t block_count = (count + block_size - 1) / block_size;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, block_count, 1), [&](const auto& blocks) {
        for (std::size_t block = blocks.begin(); block != blocks.end(); ++block) {
            progress.poll();
            work(block * block_size, std::min(count, (block + 1) * block_size));
        }
    });
}

/// work(index) for each index below count.
template <typename Work>
void parallel_for(std::size_t count, const Progress& progress, const Work& work, std::size_t block_size = 256) {
    parallel_blocks(count, block_size, progress, [&](std::size_t begin, std::size_t end) {
        for (std::size_t index = begin; index < end; ++index)
            work(index);
    });
}

/// Adds up work(begin, end) of each block, in the order of the blocks: the same bits for any number of threads.
template <typename Value, typename Work>
Value parallel_sum(std::size_t count, std::size_t block_size, Value zero, const Progress& progress, const Work& work) {
    std::vector<Value> sums((count + block_size - 1) / block_size, zero);
    parallel_blocks(count, block_size, progress,
                    [&](std::size_t begin, std::size_t end) { sums[begin / block_size] = work(begin, end); });
    Value total = zero;
    for (const Value& sum : sums)
        total += sum;
    return total;
}
} // namespace tyndall
