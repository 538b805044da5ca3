// SPDX-License-Identifier: GPL-3.0-or-later
// Nanoseconds per evaluation of the patterns that files use most, one place at a time, as surface programs ask for them.
#include "shading/patterns/noise.hpp"
#include "shading/patterns/voronoi.hpp"
#include <benchmark/benchmark.h>
#include <random>

namespace tyndall::bench {
static std::vector<vec3> places() {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> number(-10.0f, 10.0f);
    std::vector<vec3> result(4096);
    for (vec3& place : result)
        place = {number(random), number(random), number(random)};
    return result;
}

template <typename Pattern>
static void run(benchmark::State& state, const Pattern& pattern) {
    const std::vector<vec3> at = places();
    for (auto _ : state) {
        float sum = 0.0f;
        for (const vec3& place : at)
            sum += pattern(place);
        benchmark::DoNotOptimize(sum);
    }
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(at.size()));
}

/// By detail.
static void noise_3d(benchmark::State& state) {
    patterns::NoiseConfig config;
    config.octaves.detail = static_cast<float>(state.range(0));
    run(state, [&](const vec3& place) { return patterns::noise(place, config); });
}
static void noise_colour_3d(benchmark::State& state) {
    run(state, [](const vec3& place) { return patterns::noise_colour(place, {}).x; });
}
static void noise_4d(benchmark::State& state) {
    run(state, [](const vec3& place) { return patterns::noise(place, {.dimensions = 4, .w = place.x}); });
}
/// By feature.
static void voronoi_3d(benchmark::State& state) {
    const patterns::VoronoiConfig config{.feature = static_cast<patterns::VoronoiConfig::Feature>(state.range(0))};
    run(state, [&](const vec3& place) { return patterns::voronoi(place, config).distance; });
}
BENCHMARK(noise_3d)->Arg(0)->Arg(2)->Arg(8);
BENCHMARK(noise_colour_3d);
BENCHMARK(noise_4d);
BENCHMARK(voronoi_3d)->DenseRange(0, 4);
} // namespace tyndall::bench
