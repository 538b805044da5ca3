// SPDX-License-Identifier: GPL-3.0-or-later
// Attributes in the order of a packed DAG: what the order costs, look-ups, encoding, and what is lost. mesh and values as in
// attribute_array_bench.cpp; symmetry: 0 none, 1 the 8 reflections, 2 the 48 turns.
//   stored_order   bytes per entry of the values in Morton order and in stored order, and of the counts that find them; the
//                  time is that of counting and of putting values in order
//   offsets        baseline: bytes per entry of Kol 2018, 2.4.1: an offset with every reference but a node's first, in as
//                  many bytes as its level needs. It has no symmetry. Counted, not written
//   encode         colours and normals as joint materials; lossless, or in 256 colours and normals of 8 bits: bytes per
//                  entry, with and without means, and errors
//   look_up        a voxel's colour and normal, or means at a level: 2^18 of the set in no order, one thread
#include "core/random.hpp"
#include "support/attributed_meshes.hpp"
#include "support/packed_voxels.hpp"
#include "voxel_dag/encode_attributes.hpp"
#include "voxel_dag/octahedral_normals.hpp"
#include <benchmark/benchmark.h>

namespace tyndall::bench {
using namespace voxel_dag;
namespace {
using Values = std::vector<std::uint32_t>;

/// Null, and the benchmark skipped, where the mesh is not there.
const AttributedMesh* mesh_of(benchmark::State& state) {
    const AttributedMesh& mesh = attributed_mesh(state.range(0));
    if (mesh.leaves.codes.empty())
        state.SkipWithError("the mesh is not there: set TYNDALL_SHARED_DATA");
    return mesh.leaves.codes.empty() ? nullptr : &mesh;
}
void count_entries(benchmark::State& state, std::uint64_t entry_count) {
    const auto count = static_cast<double>(entry_count);
    state.counters["entries"] = count;
    state.counters["Mentry_per_s"] = benchmark::Counter(1e-6 * count, benchmark::Counter::kIsIterationInvariantRate);
}

void stored_order(benchmark::State& state) {
    const AttributedMesh* const mesh = mesh_of(state);
    if (mesh == nullptr)
        return;
    const Values& values = state.range(1) == 0 ? mesh->attributes.normals : mesh->attributes.baked;
    const PackedDag dag = support::packed(mesh->leaves, static_cast<Symmetry>(state.range(2)));
    Values stored(values.size());
    StoredOrder order;
    for (auto _ : state) {
        order = stored_order_of(dag, {});
        to_stored_order(dag, order, values, stored, {});
    }
    count_entries(state, values.size());
    const auto per_entry = [&](std::uint64_t bytes) {
        return static_cast<double>(bytes) / static_cast<double>(values.size());
    };
    state.counters["Morton_bytes"] = per_entry(run_array::encode(values, {}, {}).size());
    state.counters["stored_bytes"] = per_entry(run_array::encode(stored, {}, {}).size());
    state.counters["count_bytes"] = per_entry(order.byte_count());
    state.counters["geometry_bytes"] = per_entry(dag.byte_count());
}

/// With every reference but a node's first the number of voxels before it, in whole bytes.
std::uint64_t offset_bytes(const Dag& dag) {
    std::vector<std::uint64_t> below;
    for (const std::uint64_t leaf : dag.leaves)
        below.push_back(static_cast<std::uint64_t>(std::popcount(leaf)));
    std::uint64_t bytes = 0;
    for (const DagLevel& nodes : dag.levels) {
        std::vector<std::uint64_t> counts(nodes.node_count(), 0);
        std::uint64_t largest = 0;
        for (std::size_t node = 0; node < counts.size(); ++node)
            for (std::uint32_t i = nodes.first_children[node]; i < nodes.first_children[node + 1]; ++i) {
                largest = std::max(largest, counts[node]);
                counts[node] += below[nodes.children[i]];
            }
        bytes +=
            (nodes.children.size() - counts.size()) * ((static_cast<std::uint64_t>(std::bit_width(largest)) + 7) / 8);
        below = std::move(counts);
    }
    return bytes;
}
void offsets(benchmark::State& state) {
    const AttributedMesh* const mesh = mesh_of(state);
    if (mesh == nullptr)
        return;
    const Dag dag = build_dag(mesh->leaves, {}, {});
    std::uint64_t bytes = 0;
    for (auto _ : state)
        bytes = offset_bytes(dag);
    state.counters["count_bytes"] = static_cast<double>(bytes) / static_cast<double>(dag.voxel_count());
}

/// The 12 bits of each attribute, as what a DAG keeps.
voxel_dag::VoxelAttributes joint(const VoxelAttributes& values) {
    std::vector<std::uint32_t> codes(1 << 12);
    for (std::uint32_t code = 0; code < codes.size(); ++code) {
        const dvec2 at(static_cast<double>(code >> 6) / 31.5 - 1.0, static_cast<double>(code & 63) / 31.5 - 1.0);
        const double z = 1.0 - std::abs(at.x) - std::abs(at.y), fold = std::max(0.0, -z);
        codes[code] = octahedral::encode({at.x - std::copysign(fold, at.x), at.y - std::copysign(fold, at.y), z},
                                         octahedral::most_bits);
    }
    voxel_dag::VoxelAttributes attributes;
    for (const std::uint32_t normal : values.normals)
        attributes.normals.push_back(codes[normal]);
    for (const std::uint32_t color : values.baked)
        attributes.colors.push_back(17 * ((color >> 8) | (color >> 4 & 15) << 8 | (color & 15) << 16));
    return attributes;
}

void encode(benchmark::State& state) {
    const AttributedMesh* const mesh = mesh_of(state);
    if (mesh == nullptr)
        return;
    const PackedDag dag = support::packed(mesh->leaves, Symmetry::Cube);
    const voxel_dag::VoxelAttributes attributes = joint(mesh->attributes);
    const AttributeConfig config =
        state.range(1) == 0 ? AttributeConfig{} : AttributeConfig{.color_count = 256, .normal_bits = 8};
    std::shared_ptr<const DagAttributes> kept;
    for (auto _ : state)
        kept = encode_attributes(dag, attributes, config, {});
    count_entries(state, dag.voxel_count);
    const AttributeParts& parts = kept->parts();
    const auto per_entry = [&](std::uint64_t bytes) {
        return static_cast<double>(bytes) / static_cast<double>(dag.voxel_count);
    };
    state.counters["indices"] = per_entry(parts.voxels.indices.size());
    state.counters["materials"] = per_entry(parts.voxels.materials.size());
    state.counters["counts"] = per_entry(parts.order.byte_count());
    state.counters["means"] = per_entry(parts.means.indices.size() + parts.means.materials.size());
    state.counters["mean_count"] = static_cast<double>(parts.order.node_count);
    state.counters["mean_cie94"] = parts.errors.mean_cie94;
    state.counters["most_cie94"] = parts.errors.most_cie94;
    state.counters["mean_degrees"] = parts.errors.mean_degrees;
    state.counters["most_degrees"] = parts.errors.most_degrees;
}

void look_up(benchmark::State& state) {
    const AttributedMesh* const mesh = mesh_of(state);
    if (mesh == nullptr)
        return;
    constexpr std::uint32_t count = 1u << 18;
    const PackedDag dag = support::packed(mesh->leaves, Symmetry::Cube);
    const auto kept = encode_attributes(dag, joint(mesh->attributes), {}, {});
    std::vector<Voxel> voxels;
    for (std::uint32_t i = 0; i < count; ++i) {
        const auto brick = static_cast<std::size_t>(std::uint64_t{hash(i)} * mesh->leaves.codes.size() >> 32);
        const auto bit = static_cast<std::uint64_t>(std::countr_zero(mesh->leaves.masks[brick]));
        voxels.push_back(voxel_at(mesh->leaves.codes[brick] << 6 | bit));
    }
    std::uint64_t sum = 0;
    for (auto _ : state)
        for (const Voxel& voxel : voxels)
            sum += kept->sample_at(dag, voxel, static_cast<std::uint32_t>(state.range(1)))->color;
    benchmark::DoNotOptimize(sum);
    state.counters["Mlookup_per_s"] = benchmark::Counter(1e-6 * count, benchmark::Counter::kIsIterationInvariantRate);
}
} // namespace

static void in_ms(benchmark::internal::Benchmark* it) { it->UseRealTime()->Unit(benchmark::kMillisecond); }
BENCHMARK(stored_order)
    ->ArgNames({"mesh", "values", "symmetry"})
    ->ArgsProduct({{0, 1}, {0, 1}, {0, 1, 2}})
    ->Apply(in_ms);
BENCHMARK(offsets)->ArgName("mesh")->Arg(0)->Arg(1)->Apply(in_ms);
BENCHMARK(encode)->ArgNames({"mesh", "lossy"})->ArgsProduct({{0, 1}, {0, 1}})->Apply(in_ms);
BENCHMARK(look_up)->ArgNames({"mesh", "level"})->ArgsProduct({{0, 1}, {0, 2, 3, 4, 6}})->Apply(in_ms);
} // namespace tyndall::bench
