// SPDX-License-Identifier: GPL-3.0-or-later
// The loops of parallel.cpp on std::thread, for the thread sanitizer, which takes the hand-overs inside Debian's TBB for
// races: it was not compiled with it. At least four threads, that they meet on two cores, too; loops within loops stay
// in the thread that comes to them.
#include "core/parallel.hpp"
#include "core/parallel_in_order.hpp"
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

namespace tyndall::parallel {
static thread_local int thread_limit = 0; // 0: as many as there may be

/// Runs work() in so many threads, and throws what the first of them threw.
template <typename Work>
static void in_threads(std::size_t thread_count, const Work& work) {
    std::mutex mutex;
    std::exception_ptr thrown;
    std::vector<std::thread> threads;
    for (std::size_t i = 0; i < thread_count; ++i)
        threads.emplace_back([&] {
            thread_limit = 1;
            try {
                work();
            } catch (...) {
                const std::lock_guard lock(mutex);
                if (!thrown)
                    thrown = std::current_exception();
            }
        });
    for (std::thread& thread : threads)
        thread.join();
    if (thrown)
        std::rethrow_exception(thrown);
}

static std::size_t thread_count() {
    return thread_limit > 0 ? static_cast<std::size_t>(thread_limit)
                            : std::max<std::size_t>(4, std::thread::hardware_concurrency());
}

void run(int limit, void* work, void (*call)(void* work)) {
    const int outer_limit = std::exchange(thread_limit, limit > 0 ? limit : thread_limit);
    try {
        call(work);
    } catch (...) {
        thread_limit = outer_limit;
        throw;
    }
    thread_limit = outer_limit;
}

void run_blocks(std::size_t count, std::size_t block_size, const Progress& progress, const void* work,
                void (*call)(const void* work, std::size_t begin, std::size_t end)) {
    const std::size_t block_count = (count + block_size - 1) / block_size;
    std::atomic<std::size_t> next = 0;
    const auto take_blocks = [&] {
        try {
            for (std::size_t block = next++; block < block_count; block = next++) {
                progress.poll();
                call(work, block * block_size, std::min(count, (block + 1) * block_size));
            }
        } catch (...) {
            next = block_count; // nobody begins another
            throw;
        }
    };
    if (const std::size_t threads = std::min(block_count, thread_count()); threads > 1)
        in_threads(threads, take_blocks);
    else
        take_blocks();
}

void run_in_order(std::size_t count, std::size_t slot_count, const Progress& progress, const void* work,
                  void (*make)(const void* work, std::size_t index), void (*put)(const void* work, std::size_t index)) {
    std::mutex mutex;
    std::condition_variable changed;
    std::size_t begun = 0, done = 0;
    bool is_over = false;
    const auto take_pieces = [&] {
        std::unique_lock lock(mutex);
        try {
            for (;;) {
                changed.wait(lock, [&] { return is_over || begun == count || begun - done < slot_count; });
                if (is_over || begun == count)
                    return;
                progress.poll();
                const std::size_t index = begun++;
                lock.unlock();
                make(work, index);
                lock.lock();
                changed.wait(lock, [&] { return is_over || done == index; });
                if (is_over)
                    return;
                put(work, index);
                ++done;
                changed.notify_all();
            }
        } catch (...) {
            if (!lock.owns_lock())
                lock.lock();
            is_over = true;
            changed.notify_all();
            throw;
        }
    };
    in_threads(std::min(slot_count, thread_count()), take_pieces);
}
} // namespace tyndall::parallel
