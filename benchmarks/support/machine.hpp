// SPDX-License-Identifier: GPL-3.0-or-later
// What the machine can do in this run, so that times of different machines can be compared: a memory-bound row scales
// with the triad, a compute-bound one with the multiply-adds.
#pragma once
#include <benchmark/benchmark.h>
#include <chrono>
#include <tbb/parallel_for.h>
#include <vector>

namespace tyndall::bench {
/// a = b + s c over 3 arrays of 64 MiB, all threads, best of 5: bytes read and written per second.
inline double triad_bytes_per_s() {
    constexpr std::size_t count = std::size_t{16} << 20, block = 1 << 16;
    std::vector<float> a(count), b(count, 1.0f), c(count, 2.0f);
    double best_s = 1e9;
    for (int run = 0; run < 5; ++run) {
        const auto start = std::chrono::steady_clock::now();
        tbb::parallel_for(std::size_t{0}, count / block, [&](std::size_t part) {
            for (std::size_t i = part * block; i < (part + 1) * block; ++i)
                a[i] = b[i] + 3.0f * c[i];
        });
        benchmark::DoNotOptimize(a.data());
        benchmark::ClobberMemory();
        best_s = std::min(best_s, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    }
    return 3.0 * sizeof(float) * count / best_s;
}

/// Multiply-adds per second of one thread at the baseline's width (4 floats), best of 5.
inline double multiply_adds_per_s() {
    constexpr int steps = 1 << 20, chains = 8, lanes = 4;
    double best_s = 1e9;
    for (int run = 0; run < 5; ++run) {
        float values[chains][lanes] = {};
        const auto start = std::chrono::steady_clock::now();
        for (int step = 0; step < steps; ++step)
            for (auto& chain : values)
                for (float& value : chain)
                    value = value * 0.999f + 0.001f;
        benchmark::DoNotOptimize(values);
        best_s = std::min(best_s, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    }
    return double{steps} * chains * lanes / best_s;
}

/// Adds both to the JSON's context, once per executable.
inline void add_machine_to_context() {
    benchmark::AddCustomContext("triad_gb_per_s", std::to_string(triad_bytes_per_s() * 1e-9));
    benchmark::AddCustomContext("multiply_adds_g_per_s_and_thread", std::to_string(multiply_adds_per_s() * 1e-9));
}
} // namespace tyndall::bench
