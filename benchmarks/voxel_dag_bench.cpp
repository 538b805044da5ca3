// SPDX-License-Identifier: GPL-3.0-or-later
// From bricks of voxels (thin rule) to DAGs, packed bits and back. mesh: 0 the Stanford dragon, 1 Sponza-LowPoly.
//   build_plain       leaves and inner levels, from bricks in memory
//   merge/8, /48      symmetries, on the plain DAG's nodes
//   mesh_to_packed    triangles to packed bits with 48 turns, all steps
//   pack, decode      the DAG with 48 turns to packed bits, and those back to bricks, which are compared
//   contains          a million voxels of the set and of its surroundings: in the packed bits, and in the arrays
//   trace_primary     1024 x 1024 rays of a camera: in the packed bits, and in the arrays, one thread
//   trace_random      rays from points on a sphere around, aimed at voxels
// Counters: voxels; bytes packed. Labels: nodes / references of the first four levels.
#include "support/machine.hpp"
#include "support/voxel_meshes.hpp"
#include "support/voxel_ray_sets.hpp"
#include "voxel_dag/build_dag.hpp"
#include "voxel_dag/dag_counts.hpp"
#include "voxel_dag/decode.hpp"
#include "voxel_dag/merge_symmetric.hpp"
#include "voxel_dag/pack_dag.hpp"
#include "voxel_dag/voxelize.hpp"
#include <benchmark/benchmark.h>
#include <map>
#include <random>

namespace tyndall::bench {
using namespace voxel_dag;
namespace {
const BareMesh* mesh(std::int64_t which) {
    static const bool has_machine = (add_machine_to_context(), true);
    return has_machine ? bare_mesh(which) : nullptr;
}

/// The set of the run at work: one of 600 M voxels takes half a GiB, so only the last one is kept. Nothing without mesh.
const LeafMasks* voxels_of(benchmark::State& state) {
    static std::pair<std::int64_t, std::int64_t> kept{-1, -1};
    static LeafMasks voxels;
    const BareMesh* const bare = mesh(state.range(0));
    if (bare == nullptr) {
        state.SkipWithError("the mesh is not there: set TYNDALL_SHARED_DATA");
        return nullptr;
    }
    if (kept != std::pair{state.range(0), state.range(1)}) {
        voxels = {};
        voxels = voxelize(std::span<const vec3>(bare->positions), bare->triangles,
                          {.resolution = static_cast<std::uint32_t>(state.range(1))}, Progress())
                     .leaves;
        kept = {state.range(0), state.range(1)};
    }
    return &voxels;
}

void report(benchmark::State& state, const LeafMasks& voxels, const Dag& dag) {
    std::string label;
    for (const LevelCounts& counts : level_counts(dag))
        if (counts.level < leaf_level + 4)
            label += std::to_string(1u << counts.level) + "^3: " + std::to_string(counts.node_count) + " / " +
                     std::to_string(counts.reference_count) + "; ";
    state.SetLabel(label);
    state.counters["voxels"] = static_cast<double>(voxels.voxel_count());
    state.counters["mvoxels_per_s"] = benchmark::Counter(1e-6 * static_cast<double>(voxels.voxel_count()),
                                                         benchmark::Counter::kIsIterationInvariantRate);
}

void build_plain(benchmark::State& state) {
    const LeafMasks* const voxels = voxels_of(state);
    if (voxels == nullptr)
        return;
    Dag dag;
    for (auto _ : state)
        dag = build_dag(*voxels, {}, Progress());
    report(state, *voxels, dag);
}

void merge(benchmark::State& state, Symmetry symmetry) {
    const LeafMasks* const voxels = voxels_of(state);
    if (voxels == nullptr)
        return;
    const Dag plain = build_dag(*voxels, {}, Progress());
    Dag dag;
    for (auto _ : state)
        dag = merge_symmetric(plain, {.symmetry = symmetry}, Progress());
    report(state, *voxels, dag);
}

void mesh_to_packed(benchmark::State& state) {
    const BareMesh* const bare = mesh(state.range(0));
    if (bare == nullptr) {
        state.SkipWithError("the mesh is not there: set TYNDALL_SHARED_DATA");
        return;
    }
    PackedDag packed;
    double voxel_count = 0.0;
    for (auto _ : state) {
        const VoxelizeResult result = voxelize(std::span<const vec3>(bare->positions), bare->triangles,
                                               {.resolution = static_cast<std::uint32_t>(state.range(1))}, Progress());
        packed = pack_dag(merge_symmetric(build_dag(result.leaves, {}, Progress()), {}, Progress()), Progress());
        voxel_count = static_cast<double>(result.statistics.voxel_count);
    }
    state.counters["voxels"] = voxel_count;
    state.counters["packed_bytes"] = static_cast<double>(packed.byte_count());
    state.counters["mvoxels_per_s"] =
        benchmark::Counter(1e-6 * voxel_count, benchmark::Counter::kIsIterationInvariantRate);
}

void pack(benchmark::State& state, Symmetry symmetry) {
    const LeafMasks* const voxels = voxels_of(state);
    if (voxels == nullptr)
        return;
    Dag dag = build_dag(*voxels, {}, Progress());
    if (symmetry != Symmetry::None)
        dag = merge_symmetric(dag, {.symmetry = symmetry}, Progress());
    PackedDag packed;
    for (auto _ : state)
        packed = pack_dag(dag, Progress());
    report(state, *voxels, dag);
    state.counters["packed_bytes"] = static_cast<double>(packed.byte_count());
}

void decode_packed(benchmark::State& state) {
    const LeafMasks* const voxels = voxels_of(state);
    if (voxels == nullptr)
        return;
    const Dag dag = merge_symmetric(build_dag(*voxels, {}, Progress()), {}, Progress());
    const PackedDag packed = pack_dag(dag, Progress());
    std::size_t brick = 0;
    bool is_equal = true;
    for (auto _ : state) {
        brick = 0;
        const auto compare = [&](const LeafMasks& part) {
            const auto at = static_cast<std::ptrdiff_t>(brick);
            brick += part.codes.size();
            is_equal = is_equal && brick <= voxels->codes.size() &&
                       std::equal(part.codes.begin(), part.codes.end(), voxels->codes.begin() + at) &&
                       std::equal(part.masks.begin(), part.masks.end(), voxels->masks.begin() + at);
        };
        decode(packed, 1 << 16, compare, Progress());
    }
    if (!is_equal || brick != voxels->codes.size())
        state.SkipWithError("what came back is not what was put in");
    report(state, *voxels, dag);
}

/// Under the 48 turns, in arrays or packed.
template <class Kind>
Kind merged(const LeafMasks& voxels) {
    Dag dag = merge_symmetric(build_dag(voxels, {}, Progress()), {}, Progress());
    if constexpr (std::is_same_v<Kind, PackedDag>)
        return pack_dag(dag, Progress());
    else
        return dag;
}

template <class Kind>
void contains(benchmark::State& state) {
    const LeafMasks* const voxels = voxels_of(state);
    if (voxels == nullptr)
        return;
    const auto asked = merged<Kind>(*voxels);
    std::mt19937_64 random(1);
    std::vector<Voxel> places;
    for (int i = 0; i < 1 << 20; ++i)
        places.push_back(voxel_at(voxels->codes[random() % voxels->codes.size()] << 6 | (random() & 63)));
    std::size_t found = 0;
    for (auto _ : state)
        for (const Voxel& place : places)
            found += asked.contains(place);
    benchmark::DoNotOptimize(found);
    state.counters["per_s"] =
        benchmark::Counter(static_cast<double>(places.size()), benchmark::Counter::kIsIterationInvariantRate);
}

template <class Kind>
void trace_rays(benchmark::State& state, std::vector<VoxelRay> (*make_rays)(const LeafMasks&)) {
    const LeafMasks* const voxels = voxels_of(state);
    if (voxels == nullptr)
        return;
    const auto traced = merged<Kind>(*voxels);
    const std::vector<VoxelRay> rays = make_rays(*voxels);
    std::size_t hit_count = 0;
    for (auto _ : state) {
        hit_count = 0;
        for (const VoxelRay& ray : rays)
            hit_count += trace(traced, ray).is_hit();
    }
    const auto ray_count = static_cast<double>(rays.size());
    state.counters["hit_share"] = static_cast<double>(hit_count) / ray_count;
    state.counters["mrays_per_s"] = benchmark::Counter(1e-6 * ray_count, benchmark::Counter::kIsIterationInvariantRate);
}
template <class Kind>
void trace_primary(benchmark::State& state) {
    trace_rays<Kind>(state, primary_rays);
}
template <class Kind>
void trace_random(benchmark::State& state) {
    trace_rays<Kind>(state, random_rays);
}

void meshes(benchmark::internal::Benchmark* run) {
    run->ArgNames({"mesh", "resolution"})->UseRealTime()->Unit(benchmark::kMillisecond);
    run->Args({0, 4096})->Args({0, 8192})->Args({1, 8192});
}
} // namespace

BENCHMARK(build_plain)->Apply(meshes);
BENCHMARK_CAPTURE(merge, 8, Symmetry::Reflections)->Apply(meshes);
BENCHMARK_CAPTURE(merge, 48, Symmetry::Cube)->Apply(meshes);
BENCHMARK_CAPTURE(pack, none, Symmetry::None)->Apply(meshes);
BENCHMARK_CAPTURE(pack, 8, Symmetry::Reflections)->Apply(meshes);
BENCHMARK_CAPTURE(pack, 48, Symmetry::Cube)->Apply(meshes);
BENCHMARK(mesh_to_packed)->Apply(meshes);
BENCHMARK(decode_packed)->Apply(meshes);
BENCHMARK_TEMPLATE(contains, PackedDag)->Apply(meshes);
BENCHMARK_TEMPLATE(contains, Dag)->Apply(meshes);
BENCHMARK_TEMPLATE(trace_primary, PackedDag)->Apply(meshes);
BENCHMARK_TEMPLATE(trace_primary, Dag)->Apply(meshes);
BENCHMARK_TEMPLATE(trace_random, PackedDag)->Apply(meshes);
BENCHMARK_TEMPLATE(trace_random, Dag)->Apply(meshes);
} // namespace tyndall::bench
