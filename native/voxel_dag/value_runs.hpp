// SPDX-License-Identifier: GPL-3.0-or-later
// Runs of equal values, and for each run where its value was before and comes again: a value is new in a block that
// begins with run b exactly if the run before it of the same value lies before b.
// Bound:    12 bytes per run; one comparison per entry, a few ns per run.
#pragma once
#include "core/progress.hpp"
#include <cstdint>
#include <span>
#include <vector>

namespace tyndall::voxel_dag {
struct ValueRuns {
    std::vector<std::uint32_t> starts;   ///< Entry of each run's begin, and the number of entries behind the last.
    std::vector<std::uint32_t> previous; ///< 1 + the run before of the same value; 0 where there is none.
    std::vector<std::uint32_t> next;     ///< The next run of the same value; the number of runs where there is none.
    [[nodiscard]] std::uint32_t size() const { return static_cast<std::uint32_t>(previous.size()); }
    [[nodiscard]] std::uint32_t entries(std::uint32_t begin, std::uint32_t end) const {
        return starts[end] - starts[begin];
    }
};
/// Throws InvalidInput, which names the first index that is not below material_count, and Cancelled.
[[nodiscard]] ValueRuns value_runs_of(std::span<const std::uint32_t> indices, std::uint32_t material_count,
                                      const Progress& progress);
} // namespace tyndall::voxel_dag
