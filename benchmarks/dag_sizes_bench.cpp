// SPDX-License-Identifier: GPL-3.0-or-later
// Bytes of one set of voxels (thin rule) by structure: the rows of Jaspe, dissertation 2018, table 5.4, and ours last.
//   svo        without pointers: a byte per node of an octree, down to those of 2 x 2 x 2 voxels
//   svdag      equal subtrees once, in words of 32 bits (Kämpe et al. 2013)
//   esvdag     the same in the published layout of half-words
//   ussvdag    8 reflections, in words of 32 bits
//   ssvdag     8 reflections, in the published layout
//   ours_none, ours_8, ours_48   packed (packed_dag.hpp), without turns, with reflections, with the cube's 48
// mesh: 0 the Stanford dragon, 1 Sponza-LowPoly. All but svo and ours are counted, not written.
#include "support/voxel_meshes.hpp"
#include "voxel_dag/build_dag.hpp"
#include "voxel_dag/dag_counts.hpp"
#include "voxel_dag/merge_symmetric.hpp"
#include "voxel_dag/pack_dag.hpp"
#include "voxel_dag/tree_counts.hpp"
#include "voxel_dag/voxelize.hpp"
#include <benchmark/benchmark.h>

namespace tyndall::bench {
using namespace voxel_dag;

static void sizes(benchmark::State& state) {
    const BareMesh* const bare = bare_mesh(state.range(0));
    if (bare == nullptr) {
        state.SkipWithError("the mesh is not there: set TYNDALL_SHARED_DATA");
        return;
    }
    const Progress progress;
    const auto report = [&](const char* name, std::uint64_t bytes) {
        state.counters[name] = static_cast<double>(bytes);
    };
    for (auto _ : state) {
        const VoxelizeResult voxels = voxelize(std::span<const vec3>(bare->positions), bare->triangles,
                                               {.resolution = static_cast<std::uint32_t>(state.range(1))}, progress);
        report("voxels", voxels.statistics.voxel_count);
        const Dag plain = build_dag(voxels.leaves, {}, progress);
        report("svdag", word_bytes(plain));
        report("esvdag", half_word_bytes(plain));
        const PackedDag packed = pack_dag(plain, progress);
        report("ours_none", packed.byte_count());
        std::uint64_t octree_nodes = 0;
        for (const TreeCounts& counts : tree_counts(packed, progress))
            octree_nodes += counts.tree_count;
        report("svo", octree_nodes);
        const Dag reflected = merge_symmetric(plain, {.symmetry = Symmetry::Reflections}, progress);
        report("ussvdag", word_bytes(reflected));
        report("ssvdag", half_word_bytes(reflected));
        report("ours_8", pack_dag(reflected, progress).byte_count());
        report("ours_48", pack_dag(merge_symmetric(plain, {}, progress), progress).byte_count());
    }
}
BENCHMARK(sizes)
    ->ArgNames({"mesh", "resolution"})
    ->ArgsProduct({{0, 1}, {1024, 2048, 4096, 8192}})
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
} // namespace tyndall::bench
