// SPDX-License-Identifier: GPL-3.0-or-later
// One set of voxels (thin rule) in every structure: bytes as files have them, and rays traced in place. Jaspe, dissertation
// 2018, table 5.4 and figure 5.13, with ours last.
//   svo          a byte per node of an octree, without pointers; rays need 4 bytes more per node of 4 x 4 x 4 and above
//   svdag        equal subtrees once, in words of 32 bits (Kämpe et al. 2013)
//   esvdag       the same in half-words
//   ussvdag      8 reflections, in words of 32 bits
//   ssvdag       8 reflections, in half-words
//   kol, kol_offsets   no symmetry, references by use in 1 to 4 bytes, and with what finds attributes (Kol 2018)
//   ours_none, ours_8, ours_48   packed (packed_dag.hpp), without turns, with reflections, with the cube's 48
// mesh: 0 the Stanford dragon, 1 Sponza-LowPoly. Counters: bytes; millions of primary and of random rays per second of one
// thread's processor time, which other programs take little of, one ray after the other by the same code for all
// (trace_through.hpp); many_*: ours by a Tracer, eight at a time.
#include "baselines/entropy_dag.hpp"
#include "baselines/half_word_dag.hpp"
#include "baselines/octree_bytes.hpp"
#include "baselines/word_dag.hpp"
#include "core/parallel.hpp"
#include "support/machine.hpp"
#include "support/voxel_meshes.hpp"
#include "support/voxel_ray_sets.hpp"
#include "voxel_dag/build_dag.hpp"
#include "voxel_dag/merge_symmetric.hpp"
#include "voxel_dag/pack_dag.hpp"
#include "voxel_dag/trace_through.hpp"
#include "voxel_dag/tracer.hpp"
#include "voxel_dag/voxelize.hpp"
#include <benchmark/benchmark.h>
#include <ctime>
#include <map>

namespace tyndall::bench {
using namespace voxel_dag;
using namespace baselines;
namespace {
/// The set of the run at work.
struct Voxels {
    LeafMasks leaves;
    Dag plain, reflected;
    std::map<std::string, std::vector<VoxelRay>> rays;
};
const Voxels* voxels_of(benchmark::State& state) {
    static std::pair<std::int64_t, std::int64_t> kept{-1, -1};
    static Voxels voxels;
    static const bool has_machine = (add_machine_to_context(), true);
    const BareMesh* const mesh = has_machine ? bare_mesh(state.range(0)) : nullptr;
    if (mesh == nullptr) {
        state.SkipWithError("the mesh is not there: set TYNDALL_SHARED_DATA");
        return nullptr;
    }
    if (const std::pair wanted(state.range(0), state.range(1)); kept != wanted) {
        voxels = {};
        voxels.leaves = voxelize(std::span<const vec3>(mesh->positions), mesh->triangles,
                                 {.resolution = static_cast<std::uint32_t>(state.range(1))}, Progress())
                            .leaves;
        voxels.plain = build_dag(voxels.leaves, {}, Progress());
        voxels.reflected = merge_symmetric(voxels.plain, {.symmetry = Symmetry::Reflections}, Progress());
        voxels.rays["primary"] = primary_rays(voxels.leaves);
        voxels.rays["random"] = random_rays(voxels.leaves);
        kept = wanted;
    }
    return &voxels;
}

/// hit_count = trace(rays), timed; reported by name.
template <class Trace>
void time_rays(benchmark::State& state, const std::string& name, std::size_t ray_count, const Trace& trace_all) {
    const std::clock_t begin = std::clock();
    benchmark::DoNotOptimize(trace_all());
    const double passed_s = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    state.counters[name] = 1e-6 * static_cast<double>(ray_count) / passed_s;
}
template <class Tree>
void time_each(benchmark::State& state, const Voxels& voxels, const Tree& tree) {
    for (const auto& [kind, rays] : voxels.rays)
        time_rays(state, kind, rays.size(), [&] {
            return std::ranges::count_if(rays, [&](const VoxelRay& ray) { return trace_through(tree, ray).is_hit(); });
        });
}

/// A layout of its own: made from what make(voxels) returns, the file's bytes.
template <class Layout, class Encode>
void published(benchmark::State& state, const Encode& encode) {
    const Voxels* const voxels = voxels_of(state);
    if (voxels == nullptr)
        return;
    const Layout layout(encode(*voxels));
    for (auto _ : state)
        time_each(state, *voxels, layout);
    state.counters["voxels"] = static_cast<double>(voxels->leaves.voxel_count());
    state.counters["bytes"] = static_cast<double>(layout.byte_count());
    if constexpr (requires { layout.pointer_bytes(); })
        state.counters["pointer_bytes"] = static_cast<double>(layout.pointer_bytes());
}

void ours(benchmark::State& state, Symmetry symmetry) {
    const Voxels* const voxels = voxels_of(state);
    if (voxels == nullptr)
        return;
    const PackedDag dag = pack_dag(symmetry == Symmetry::None          ? voxels->plain
                                   : symmetry == Symmetry::Reflections ? voxels->reflected
                                                                       : merge_symmetric(voxels->plain, {}, Progress()),
                                   Progress());
    const Tracer tracer(dag);
    for (auto _ : state) {
        time_each(state, *voxels, dag);
        for (const auto& [kind, rays] : voxels->rays)
            time_rays(state, "many_" + kind, rays.size(), [&] {
                std::vector<VoxelHit> hits(rays.size());
                with_threads(1, [&] { tracer.trace(rays, hits, Progress()); });
                return std::ranges::count_if(hits, &VoxelHit::is_hit);
            });
    }
    state.counters["voxels"] = static_cast<double>(voxels->leaves.voxel_count());
    state.counters["bytes"] = static_cast<double>(dag.byte_count());
    state.counters["tracer_bytes"] = static_cast<double>(tracer.byte_count());
}

/// All structures of a set, before the next set is made.
const bool is_registered = [] {
    for (const std::int64_t mesh : {0, 1})
        for (const std::int64_t resolution : {1024, 2048, 4096, 8192}) {
            const auto add = [&](const char* name, const auto& run) {
                benchmark::RegisterBenchmark(name, run)
                    ->ArgNames({"mesh", "resolution"})
                    ->Args({mesh, resolution})
                    ->Iterations(1)
                    ->Unit(benchmark::kMillisecond);
            };
            using State = benchmark::State;
            add("svo", [](State& state) {
                published<OctreeBytes>(state, [](const Voxels& all) { return OctreeBytes::encode(all.leaves); });
            });
            add("svdag", [](State& state) {
                published<WordDag>(state, [](const Voxels& all) { return WordDag::encode(all.plain); });
            });
            add("esvdag", [](State& state) {
                published<HalfWordDag>(state, [](const Voxels& all) { return HalfWordDag::encode(all.plain); });
            });
            add("ussvdag", [](State& state) {
                published<WordDag>(state, [](const Voxels& all) { return WordDag::encode(all.reflected); });
            });
            add("ssvdag", [](State& state) {
                published<HalfWordDag>(state, [](const Voxels& all) { return HalfWordDag::encode(all.reflected); });
            });
            for (const bool has_offsets : {false, true})
                add(has_offsets ? "kol_offsets" : "kol", [=](State& state) {
                    published<EntropyDag>(state, [=](const Voxels& all) {
                        return EntropyDag::encode(all.plain, {.has_table = true, .has_offsets = has_offsets});
                    });
                });
            add("ours_none", [](State& state) { ours(state, Symmetry::None); });
            add("ours_8", [](State& state) { ours(state, Symmetry::Reflections); });
            add("ours_48", [](State& state) { ours(state, Symmetry::Cube); });
        }
    return true;
}();
} // namespace
} // namespace tyndall::bench
