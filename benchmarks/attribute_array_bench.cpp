// SPDX-License-Identifier: GPL-3.0-or-later
// Attribute arrays: bytes per entry and entries per second, of Algorithm 1 (Kol 2018) and of ours. mesh: 0 the Stanford
// dragon at 4096^3, 1 Sponza-LowPoly at 2048^3, thin; values: 0 normals, 1 baked colours, 12 bits, as
// support/voxel_attributes.hpp defines them. partition and the reads are one thread's; encoders use all.
#include "core/random.hpp"
#include "support/attributed_meshes.hpp"
#include "voxel_dag/color_palette.hpp"
#include "voxel_dag/joint_materials.hpp"
#include "voxel_dag/material_indices.hpp"
#include "voxel_dag/palette_array.hpp"
#include "voxel_dag/palette_blocks.hpp"
#include "voxel_dag/run_array.hpp"
#include <benchmark/benchmark.h>

namespace tyndall::bench {
using namespace voxel_dag;
namespace {
using Values = std::vector<std::uint32_t>;

const VoxelAttributes& attributes_of(std::int64_t mesh) { return attributed_mesh(mesh).attributes; }
/// Empty, and the benchmark skipped, where the mesh is not there.
const Values& values_of(benchmark::State& state) {
    const VoxelAttributes& attributes = attributes_of(state.range(0));
    const Values& values = state.range(1) == 0 ? attributes.normals : attributes.baked;
    if (values.empty())
        state.SkipWithError("the mesh is not there: set TYNDALL_SHARED_DATA");
    state.counters["orphans"] = static_cast<double>(attributes.orphan_count);
    return values;
}
void report(benchmark::State& state, std::size_t entry_count, std::uint64_t byte_count) {
    const auto count = static_cast<double>(entry_count);
    state.counters["entries"] = count;
    state.counters["Mentry_per_s"] = benchmark::Counter(1e-6 * count, benchmark::Counter::kIsIterationInvariantRate);
    if (byte_count > 0)
        state.counters["bytes_per_entry"] = static_cast<double>(byte_count) / count;
}

void algorithm_1_blocks(benchmark::State& state) {
    const MaterialIndices found = material_indices_of(values_of(state), {});
    const auto material_count = static_cast<std::uint32_t>(found.materials.size());
    std::size_t block_count = 0;
    for (auto _ : state)
        block_count = palette_blocks::partition(found.indices, material_count, {}, {}).size();
    report(state, found.indices.size(), 0);
    state.counters["blocks"] = static_cast<double>(block_count);
    state.counters["materials"] = material_count;
}
std::vector<std::uint8_t> palettes_of(benchmark::State& state) { return encode_palettes(values_of(state), {}, {}); }
std::vector<std::uint8_t> runs_of(benchmark::State& state) {
    return run_array::encode(values_of(state), {.log2_block_entries = static_cast<std::uint32_t>(state.range(2))}, {});
}

template <auto encode>
void encoded(benchmark::State& state) {
    std::vector<std::uint8_t> bytes;
    for (auto _ : state)
        bytes = encode(state);
    report(state, values_of(state).size(), bytes.size());
}
template <typename Array, auto encode>
void opened(benchmark::State& state) {
    const std::vector<std::uint8_t> bytes = encode(state);
    for (auto _ : state)
        benchmark::DoNotOptimize(Array(bytes));
    state.counters["bytes"] = static_cast<double>(bytes.size());
}
template <typename Array, auto encode>
void decoded(benchmark::State& state) {
    const std::vector<std::uint8_t> bytes = encode(state);
    const Array array(bytes);
    Values values(array.size());
    for (auto _ : state)
        array.decode(0, values);
    report(state, values.size(), bytes.size());
    if (values != values_of(state))
        state.SkipWithError("what was decoded differs");
}
/// 2^20 entries all over the array, in no order.
template <typename Array, auto encode>
void read_at_random(benchmark::State& state) {
    constexpr std::uint32_t count = 1u << 20;
    const std::vector<std::uint8_t> bytes = encode(state);
    const Array array(bytes);
    std::uint64_t sum = 0;
    for (auto _ : state)
        for (std::uint32_t i = 0; array.size() > 0 && i < count; ++i)
            sum += array.at(static_cast<std::uint32_t>(std::uint64_t{hash(i)} * array.size() >> 32));
    benchmark::DoNotOptimize(sum);
    state.counters["Mread_per_s"] = benchmark::Counter(1e-6 * count, benchmark::Counter::kIsIterationInvariantRate);
}

/// Normals and colours as one material, in one array and a table, against an array of each.
void joint_materials(benchmark::State& state) {
    const VoxelAttributes& attributes = attributes_of(state.range(0));
    const std::array<std::span<const std::uint32_t>, 2> both{attributes.normals, attributes.baked};
    std::uint64_t bytes = 0;
    std::size_t material_count = 0;
    for (auto _ : state) {
        const JointMaterials joint = join(both, {});
        bytes = run_array::encode(joint.indices, {}, {}).size() + encode_columns(joint).size();
        material_count = joint.columns[0].size();
    }
    report(state, attributes.normals.size(), bytes);
    state.counters["materials"] = static_cast<double>(material_count);
    std::uint64_t apart = 0;
    for (const auto& values : both)
        apart += run_array::encode(values, {}, {}).size();
    state.counters["apart_bytes_per_entry"] =
        static_cast<double>(apart) / static_cast<double>(attributes.normals.size());
}

/// Colours of 24 bits, the baked ones times a gradient of 16 shades along the array, as few: by number, or by difference.
void colors_quantized(benchmark::State& state) {
    std::vector<PackedColor> colors = values_of(state);
    for (std::size_t i = 0; i < colors.size(); ++i) {
        const PackedColor color = colors[i], shade = static_cast<PackedColor>(16 * i / colors.size());
        colors[i] = (color >> 8) * 16 << 16 | (color >> 4 & 15) * 16 << 8 | (color & 15) * 16;
        colors[i] += shade * 0x010101;
    }
    color_palette::Result result;
    for (auto _ : state)
        result = state.range(2) > 0 ? color_palette::of_size(colors, static_cast<std::uint32_t>(state.range(2)), {})
                                    : color_palette::within(colors, 2.3, {});
    report(state, colors.size(), 0);
    state.counters["colors"] = static_cast<double>(result.colors.size());
    state.counters["mean_cie94"] = result.statistics.mean_difference;
    state.counters["most_cie94"] = result.statistics.most_difference;
}
} // namespace

static void on_all(benchmark::internal::Benchmark* it) {
    it->ArgNames({"mesh", "values"})->ArgsProduct({{0, 1}, {0, 1}})->UseRealTime()->Unit(benchmark::kMillisecond);
}
static void on_all_sizes(benchmark::internal::Benchmark* it) {
    it->ArgNames({"mesh", "values", "log2_block"})->ArgsProduct({{0, 1}, {0, 1}, {9, 10, 11, 12}});
    it->UseRealTime()->Unit(benchmark::kMillisecond);
}
BENCHMARK(algorithm_1_blocks)->Apply(on_all);
BENCHMARK(encoded<palettes_of>)->Apply(on_all)->Name("palettes_encoded");
BENCHMARK(encoded<runs_of>)->Apply(on_all_sizes)->Name("runs_encoded");
BENCHMARK(opened<PaletteArray, palettes_of>)->Apply(on_all)->Name("palettes_opened");
BENCHMARK(opened<RunArray, runs_of>)->Apply(on_all_sizes)->Name("runs_opened");
BENCHMARK(decoded<PaletteArray, palettes_of>)->Apply(on_all)->Name("palettes_decoded");
BENCHMARK(decoded<RunArray, runs_of>)->Apply(on_all_sizes)->Name("runs_decoded");
BENCHMARK(read_at_random<PaletteArray, palettes_of>)->Apply(on_all)->Name("palettes_read_at_random");
BENCHMARK(read_at_random<RunArray, runs_of>)->Apply(on_all_sizes)->Name("runs_read_at_random");
BENCHMARK(joint_materials)->ArgName("mesh")->Arg(0)->Arg(1)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(colors_quantized)
    ->ArgNames({"mesh", "values", "colors"})
    ->ArgsProduct({{0, 1}, {1}, {0, 256, 4096}})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
} // namespace tyndall::bench
