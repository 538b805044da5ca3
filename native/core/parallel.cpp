// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/parallel.hpp"
#include "core/parallel_in_order.hpp"
#include <tbb/blocked_range.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

namespace tyndall::parallel {
void run(int thread_count, void* work, void (*call)(void* work)) {
    // TBB prints a warning when it is asked for more threads than there are cores.
    const int core_count = tbb::info::default_concurrency();
    tbb::task_arena arena(thread_count > 0 ? std::min(thread_count, core_count) : tbb::task_arena::automatic);
    arena.execute([&] { call(work); });
}

void run_blocks(std::size_t count, std::size_t block_size, const Progress& progress, const void* work,
                void (*call)(const void* work, std::size_t begin, std::size_t end)) {
    const std::size_t block_count = (count + block_size - 1) / block_size;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, block_count, 1), [&](const auto& blocks) {
        for (std::size_t block = blocks.begin(); block != blocks.end(); ++block) {
            progress.poll();
            call(work, block * block_size, std::min(count, (block + 1) * block_size));
        }
    });
}

void run_in_order(std::size_t count, std::size_t slot_count, const Progress& progress, const void* work,
                  void (*make)(const void* work, std::size_t index), void (*put)(const void* work, std::size_t index)) {
    std::size_t next = 0;
    tbb::parallel_pipeline(
        slot_count,
        tbb::make_filter<void, std::size_t>(tbb::filter_mode::serial_in_order, [&](tbb::flow_control& control) {
            progress.poll();
            if (next == count)
                control.stop();
            return next++;
        }) & tbb::make_filter<std::size_t, std::size_t>(tbb::filter_mode::parallel, [&](std::size_t index) {
            make(work, index);
            return index;
        }) & tbb::make_filter<std::size_t, void>(tbb::filter_mode::serial_in_order, [&](std::size_t index) {
            put(work, index);
        }));
}
} // namespace tyndall::parallel
