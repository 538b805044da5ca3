// SPDX-License-Identifier: GPL-3.0-or-later
// Attribute arrays that tests share: what is awkward for runs, palettes and fixed blocks.
#pragma once
#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace tyndall::voxel_dag::test {
using Values = std::vector<std::uint32_t>;

class Random {
public:
    explicit Random(std::uint32_t seed) : engine_(seed) {}
    std::uint32_t operator()() { return static_cast<std::uint32_t>(engine_()); }

private:
    std::mt19937 engine_; // whose result may be wider than its 32 bits
};

/// Below `value_count`, each the same as the one before with a chance of `stay` in 100.
inline Values random_runs(std::size_t count, std::uint32_t value_count, std::uint32_t stay, std::uint32_t seed) {
    Random random(seed);
    Values values;
    for (std::size_t i = 0; i < count; ++i)
        values.push_back(i > 0 && random() % 100 < stay ? values.back() : random() % value_count);
    return values;
}
/// Calm and busy stretches in turns, of lengths that fit no block.
inline Values patchwork(std::size_t count, std::uint32_t seed) {
    Random random(seed);
    Values values;
    while (values.size() < count) {
        const std::uint32_t first = random() % 4000, spread = 1u << random() % 9;
        const std::size_t end = std::min(count, values.size() + 1 + random() % 900);
        while (values.size() < end)
            values.push_back(first + random() % spread);
    }
    return values;
}

/// Named arrays of about `count` entries.
inline std::vector<std::pair<std::string, Values>> awkward_arrays(std::size_t count) {
    Values alternating, all_different, staircase, steps;
    for (std::uint32_t i = 0; i < count; ++i) {
        alternating.push_back(i % 2 == 0 ? 7 : 4095);
        all_different.push_back(i * 2654435761u);
        staircase.push_back(i / 37);
        steps.push_back(i / 8 % 3 * 0x7fffffffu);
    }
    std::vector<std::pair<std::string, Values>> arrays{{"constant 0", Values(count, 0)},
                                                       {"constant 2^32 - 1", Values(count, ~0u)},
                                                       {"alternating", alternating},
                                                       {"all different, 32 bits", all_different},
                                                       {"staircase", staircase},
                                                       {"runs of 8", steps},
                                                       {"noise of 2", random_runs(count, 2, 0, 1)},
                                                       {"noise of 4096", random_runs(count, 4096, 0, 2)},
                                                       {"runs of 4096", random_runs(count, 4096, 80, 3)},
                                                       {"long runs", random_runs(count, 200, 99, 4)},
                                                       {"patchwork", patchwork(count, 5)}};
    return arrays;
}
} // namespace tyndall::voxel_dag::test
