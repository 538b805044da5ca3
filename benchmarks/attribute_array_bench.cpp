// SPDX-License-Identifier: GPL-3.0-or-later
// Attribute arrays: bytes per entry and entries per second, of Algorithm 1 (Kol 2018) and of ours.
// The voxels are those of a gyroid, |g| crossing 0 between neighbours, in Morton order: g = sin x cos y + sin y cos z +
// sin z cos x with 2.5 periods a side. 512 voxels a side unless TYNDALL_GYROID_LEVEL says another power of two. A voxel
// is set where g at its centre is >= 0 and g < 0 at one of its 6 neighbours' centres. Its values have 12 bits:
//   normals: the octahedral map of grad g / |grad g|, 6 + 6 bits, each (v / 2 + 1 / 2) * 63 rounded
//   baked:   4 + 4 + 4 bits of check * marble * lambert: check 0.55 or 1, of 8 x 8 x 8 cubes; marble from (0.9, 0.85, 0.75)
//            to (0.3, 0.45, 0.6) as 1/2 + 1/2 sin(40 x + 6 sin 14 y + 4 sin 17 z), x, y, z in [0, 1]; lambert = 1/4 +
//            3/4 max(0, n . (0.48, 0.36, 0.8))
#include "core/random.hpp"
#include "voxel_dag/material_indices.hpp"
#include "voxel_dag/morton.hpp"
#include "voxel_dag/palette_array.hpp"
#include "voxel_dag/palette_blocks.hpp"
#include "voxel_dag/run_array.hpp"
#include <algorithm>
#include <benchmark/benchmark.h>
#include <cmath>
#include <cstdlib>
#include <numbers>

namespace tyndall::bench {
using namespace voxel_dag;
namespace {
using Values = std::vector<std::uint32_t>;
using Vector = std::array<double, 3>;

struct Sequences {
    Values normals, baked;
};

std::uint32_t quantized(double value, std::uint32_t bits) { // of [0, 1]
    const double most = static_cast<double>((1u << bits) - 1);
    return static_cast<std::uint32_t>(std::lround(std::clamp(value, 0.0, 1.0) * most));
}
std::uint32_t octahedral_12_bits(const Vector& n) {
    const double scale = 1.0 / (std::abs(n[0]) + std::abs(n[1]) + std::abs(n[2]));
    double u = n[0] * scale, v = n[1] * scale;
    if (n[2] < 0.0) {
        const double folded = (1.0 - std::abs(v)) * (u < 0.0 ? -1.0 : 1.0);
        v = (1.0 - std::abs(u)) * (v < 0.0 ? -1.0 : 1.0);
        u = folded;
    }
    return quantized(0.5 * u + 0.5, 6) << 6 | quantized(0.5 * v + 0.5, 6);
}
std::uint32_t baked_12_bits(const Vector& at, const Vector& n) {
    int check = 0;
    for (const double x : at)
        check += static_cast<int>(std::floor(8.0 * x));
    const double vein =
        0.5 + 0.5 * std::sin(40.0 * at[0] + 6.0 * std::sin(14.0 * at[1]) + 4.0 * std::sin(17.0 * at[2]));
    const double lambert = 0.25 + 0.75 * std::max(0.0, 0.48 * n[0] + 0.36 * n[1] + 0.8 * n[2]);
    const double shade = (check % 2 == 0 ? 1.0 : 0.55) * lambert;
    const auto channel = [&](double light, double dark) { return quantized(shade * std::lerp(light, dark, vein), 4); };
    return channel(0.9, 0.3) << 8 | channel(0.85, 0.45) << 4 | channel(0.75, 0.6);
}

/// Sines and cosines along an axis, of the centres from that before the first voxel to that behind the last.
struct Waves {
    std::vector<double> sine, cosine;
    explicit Waves(std::uint32_t side) {
        for (std::uint32_t i = 0; i < side + 2; ++i) {
            const double phase = 5.0 * std::numbers::pi * (i - 0.5) / side;
            sine.push_back(std::sin(phase));
            cosine.push_back(std::cos(phase));
        }
    }
    double g(std::size_t x, std::size_t y, std::size_t z) const {
        return sine[x] * cosine[y] + sine[y] * cosine[z] + sine[z] * cosine[x];
    }
    Vector gradient(std::size_t x, std::size_t y, std::size_t z) const {
        return {cosine[x] * cosine[y] - sine[z] * sine[x], cosine[y] * cosine[z] - sine[x] * sine[y],
                cosine[z] * cosine[x] - sine[y] * sine[z]};
    }
};

/// Descends to the octants where |g| is below what its slope (at most 3.5 phases, generously) allows.
void descend(const Waves& waves, std::uint32_t side, const Voxel& corner, std::uint32_t size, Sequences& sequences) {
    const std::size_t x = corner[0] + 1, y = corner[1] + 1, z = corner[2] + 1; // 1: the waves begin one voxel before
    if (size == 1) {
        const double g = waves.g(x, y, z);
        const bool is_surface =
            g >= 0.0 && (waves.g(x - 1, y, z) < 0.0 || waves.g(x + 1, y, z) < 0.0 || waves.g(x, y - 1, z) < 0.0 ||
                         waves.g(x, y + 1, z) < 0.0 || waves.g(x, y, z - 1) < 0.0 || waves.g(x, y, z + 1) < 0.0);
        if (!is_surface)
            return;
        Vector n = waves.gradient(x, y, z);
        const double length = std::hypot(n[0], n[1], n[2]);
        for (double& component : n)
            component /= length;
        sequences.normals.push_back(octahedral_12_bits(n));
        const auto centre = [&](std::uint32_t at) { return (at + 0.5) / side; };
        sequences.baked.push_back(baked_12_bits({centre(corner[0]), centre(corner[1]), centre(corner[2])}, n));
        return;
    }
    const std::size_t half = size / 2;
    const double reach = 3.5 * 5.0 * std::numbers::pi * (static_cast<double>(half) + 1.0) / side;
    if (std::abs(waves.g(x + half, y + half, z + half)) > reach)
        return;
    for (std::uint32_t octant = 0; octant < 8; ++octant)
        descend(waves, side,
                {corner[0] + (octant & 1) * size / 2, corner[1] + (octant >> 1 & 1) * size / 2,
                 corner[2] + (octant >> 2) * size / 2},
                size / 2, sequences);
}

const Sequences& gyroid() {
    static const Sequences made = [] {
        const char* const level = std::getenv("TYNDALL_GYROID_LEVEL");
        const std::uint32_t side = 1u << (level == nullptr ? 9 : std::clamp(std::atoi(level), 4, 12));
        Sequences sequences;
        descend(Waves(side), side, {0, 0, 0}, side, sequences);
        return sequences;
    }();
    return made;
}
const Values& values_of(const benchmark::State& state) {
    return state.range(0) == 0 ? gyroid().normals : gyroid().baked;
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
void algorithm_1_bytes(benchmark::State& state) {
    std::vector<std::uint8_t> bytes;
    for (auto _ : state)
        bytes = encode_palettes(values_of(state), {}, {});
    report(state, values_of(state).size(), bytes.size());
}
void algorithm_1_decode(benchmark::State& state) {
    const std::vector<std::uint8_t> bytes = encode_palettes(values_of(state), {}, {});
    const PaletteArray array(bytes);
    Values decoded(array.size());
    for (auto _ : state)
        array.decode(0, decoded);
    report(state, decoded.size(), bytes.size());
    if (decoded != values_of(state))
        state.SkipWithError("what was decoded differs");
}

std::vector<std::uint8_t> encode_runs(const benchmark::State& state) {
    return run_array::encode(values_of(state), {.log2_block_entries = static_cast<std::uint32_t>(state.range(1))}, {});
}
void runs_bytes(benchmark::State& state) {
    std::vector<std::uint8_t> bytes;
    for (auto _ : state)
        bytes = encode_runs(state);
    report(state, values_of(state).size(), bytes.size());
}
void runs_decode(benchmark::State& state) {
    const std::vector<std::uint8_t> bytes = encode_runs(state);
    const RunArray array(bytes);
    Values decoded(static_cast<std::size_t>(array.size()));
    for (auto _ : state)
        array.decode(0, decoded);
    report(state, decoded.size(), bytes.size());
    if (decoded != values_of(state))
        state.SkipWithError("what was decoded differs");
}
void runs_open(benchmark::State& state) {
    const std::vector<std::uint8_t> bytes = encode_runs(state);
    for (auto _ : state)
        benchmark::DoNotOptimize(RunArray(bytes));
    report(state, values_of(state).size(), bytes.size());
}

/// 2^20 entries all over the array, in no order.
template <typename Array>
void read_at_random(benchmark::State& state, const Array& array) {
    constexpr std::uint32_t count = 1u << 20;
    std::uint64_t sum = 0;
    for (auto _ : state)
        for (std::uint32_t i = 0; i < count; ++i)
            sum += array.at(static_cast<std::uint32_t>(std::uint64_t{hash(i)} * array.size() >> 32));
    benchmark::DoNotOptimize(sum);
    state.counters["Mread_per_s"] = benchmark::Counter(1e-6 * count, benchmark::Counter::kIsIterationInvariantRate);
}
void algorithm_1_random(benchmark::State& state) {
    const std::vector<std::uint8_t> bytes = encode_palettes(values_of(state), {}, {});
    read_at_random(state, PaletteArray(bytes));
}
void runs_random(benchmark::State& state) {
    const std::vector<std::uint8_t> bytes = encode_runs(state);
    read_at_random(state, RunArray(bytes));
}
} // namespace

#define TYNDALL_BOTH ->ArgName("values")->Arg(0)->Arg(1)->UseRealTime()->Unit(benchmark::kMillisecond)
BENCHMARK(algorithm_1_blocks) TYNDALL_BOTH;
BENCHMARK(algorithm_1_bytes) TYNDALL_BOTH;
BENCHMARK(algorithm_1_decode) TYNDALL_BOTH;
BENCHMARK(algorithm_1_random) TYNDALL_BOTH;
#define TYNDALL_RUNS                                                                                                   \
    ->ArgNames({"values", "log2_block"})                                                                               \
        ->ArgsProduct({{0, 1}, {9, 10, 11}})                                                                           \
        ->UseRealTime()                                                                                                \
        ->Unit(benchmark::kMillisecond)
BENCHMARK(runs_bytes) TYNDALL_RUNS;
BENCHMARK(runs_decode) TYNDALL_RUNS;
BENCHMARK(runs_open) TYNDALL_RUNS;
BENCHMARK(runs_random) TYNDALL_RUNS;
} // namespace tyndall::bench
