// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxel_dag/value_runs.hpp"
#include "core/errors.hpp"
#include <algorithm>
#include <limits>

namespace tyndall::voxel_dag {
/// Entries at which a run begins, and the number of entries.
static std::vector<std::uint32_t> run_starts(std::span<const std::uint32_t> indices, const Progress& progress) {
    constexpr std::size_t part = std::size_t{1} << 16;
    std::vector<std::uint32_t> starts, of_part(part + 1);
    for (std::size_t begin = 0; begin < indices.size(); begin += part) {
        progress.poll();
        const std::size_t end = std::min(indices.size(), begin + part);
        std::size_t count = 0;
        for (std::size_t i = begin; i < end; ++i) { // no branch: every entry is written, few are kept
            of_part[count] = static_cast<std::uint32_t>(i);
            count += i == 0 || indices[i] != indices[i - 1];
        }
        starts.insert(starts.end(), of_part.begin(), of_part.begin() + static_cast<std::ptrdiff_t>(count));
    }
    starts.push_back(static_cast<std::uint32_t>(indices.size()));
    return starts;
}

ValueRuns value_runs_of(std::span<const std::uint32_t> indices, std::uint32_t material_count,
                        const Progress& progress) {
    require(indices.size() <= std::numeric_limits<std::uint32_t>::max(), "attribute array: ", indices.size(),
            " entries; one array has at most 4,294,967,295");
    ValueRuns runs{.starts = run_starts(indices, progress), .previous = {}, .next = {}};
    const auto run_count = static_cast<std::uint32_t>(runs.starts.size() - 1);
    runs.previous.resize(run_count);
    runs.next.assign(run_count, run_count);
    std::vector<std::uint32_t> last_run(material_count); // 1 + the run
    for (std::uint32_t run = 0; run < run_count; ++run) {
        const std::uint32_t index = indices[runs.starts[run]];
        require(index < material_count, "attribute array: entry ", runs.starts[run], " is material ", index, " of ",
                material_count);
        const std::uint32_t before = last_run[index];
        runs.previous[run] = before;
        if (before != 0)
            runs.next[before - 1] = run;
        last_run[index] = run + 1;
    }
    return runs;
}
} // namespace tyndall::voxel_dag
