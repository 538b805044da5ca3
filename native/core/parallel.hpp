// SPDX-License-Identifier: GPL-3.0-or-later
// Parallel loops whose results do not depend on the number of threads: work is cut into blocks by size, never by
// thread, and a block's result belongs to the block.
// Differs from tbb::parallel_for: polls Progress before each block, and reductions add block by block in order. TBB's
// headers stay in parallel.cpp, behind one call through a pointer per block: they cost a second per file that has them.
#pragma once
#include "core/progress.hpp"
#include <algorithm>
#include <cstddef>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

namespace tyndall {
namespace parallel {
void run(int thread_count, void* work, void (*call)(void* work));
void run_blocks(std::size_t count, std::size_t block_size, const Progress& progress, const void* work,
                void (*call)(const void* work, std::size_t begin, std::size_t end));
} // namespace parallel

/// Runs work inside an arena of at most `thread_count` threads; 0 means all cores. Never tbb::global_control: where TBB
/// is shared with Blender, that throttles Blender, too.
template <typename Work>
auto with_threads(int thread_count, Work&& work) {
    using Result = std::invoke_result_t<Work&>;
    if constexpr (std::is_void_v<Result>) {
        parallel::run(thread_count, &work,
                      [](void* called) { (*static_cast<std::remove_reference_t<Work>*>(called))(); });
    } else {
        std::optional<Result> result;
        auto keep = [&] { result.emplace(work()); };
        parallel::run(thread_count, &keep, [](void* called) { (*static_cast<decltype(keep)*>(called))(); });
        return std::move(*result);
    }
}

/// work(begin, end) for consecutive blocks of at most block_size; throws Cancelled soon after progress.cancel().
template <typename Work>
void parallel_blocks(std::size_t count, std::size_t block_size, const Progress& progress, const Work& work) {
    parallel::run_blocks(count, block_size, progress, &work,
                         [](const void* called, std::size_t begin, std::size_t end) {
                             (*static_cast<const Work*>(called))(begin, end);
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
