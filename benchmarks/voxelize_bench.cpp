// SPDX-License-Identifier: GPL-3.0-or-later
// Meshes to sorted bricks of voxels, vertices in memory to bricks in memory. mesh: 0 the Stanford dragon, 1
// Sponza-LowPoly. Scale and rules are those of the published tools, so that voxels can be compared: dragon 4096 thin
// 24.57 M, 8192 thin 98.11 M, 4096 conservative 42.98 M; Sponza 4096 thin 146.2 M, 8192 thin 585.6 M.
#include "core/parallel.hpp"
#include "support/voxel_meshes.hpp"
#include "voxel_dag/voxelize.hpp"
#include <benchmark/benchmark.h>

namespace tyndall::bench {
using namespace voxel_dag;

static void voxelize_mesh(benchmark::State& state) {
    const BareMesh* const bare = bare_mesh(state.range(0));
    if (bare == nullptr) {
        state.SkipWithError("the mesh is not there: set TYNDALL_SHARED_DATA");
        return;
    }
    const VoxelizeConfig config{.resolution = static_cast<std::uint32_t>(state.range(1)),
                                .rule = static_cast<VoxelizeRule>(state.range(2))};
    const Progress progress;
    VoxelizeResult result;
    for (auto _ : state) {
        state.PauseTiming();
        result = {};
        state.ResumeTiming();
        result = with_threads(static_cast<int>(state.range(3)), [&] {
            return voxelize(std::span<const vec3>(bare->positions), bare->triangles, config, progress);
        });
    }
    const auto voxels = static_cast<double>(result.statistics.voxel_count);
    state.counters["voxels"] = voxels;
    state.counters["mvoxels_per_s"] = benchmark::Counter(voxels * 1e-6, benchmark::Counter::kIsIterationInvariantRate);
    state.counters["bricks"] = static_cast<double>(result.leaves.codes.size());
    state.counters["tiles"] = static_cast<double>(result.statistics.tile_count);
    state.counters["triangle_tiles"] = static_cast<double>(result.statistics.triangle_tile_count);
}
BENCHMARK(voxelize_mesh)
    ->ArgNames({"mesh", "resolution", "conservative", "threads"})
    ->ArgsProduct({{0, 1}, {4096, 8192}, {0, 1}, {1, 2}})
    ->MeasureProcessCPUTime() // of all threads: what a machine that others use, too, changes least
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
} // namespace tyndall::bench
