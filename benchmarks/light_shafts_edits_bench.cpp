// SPDX-License-Identifier: GPL-3.0-or-later
// Edits of occluders on maps of 1024^2, 2048^2 and 4096^2 texels, as in the tables of Kol 2018, section 5.5.
//   close_square, close_disc     closing by a kernel 41 texels wide       plain_close_*   the same, a texel at a time:
//   close_rows                   closing of length 61 along every row                     two separable passes of 41 (61)
//   dilate_rows                  silhouettes drawn out by 60 samples                      comparisons, no SIMD, one thread
//   holes, moving_holes          5 octaves at 50 texels per cell: one lookup, and two     plain_moving_holes: textbook
//   moving_holes_in_space        the same for lamps                                       noise, table of gradients
// In place, over and over: a closing costs the same whatever the map holds.
#include "core/math.hpp"
#include "core/parallel.hpp"
#include "light_shafts/flat_filters.hpp"
#include "light_shafts/hole_noise.hpp"
#include "light_shafts/slope_rows.hpp"
#include "support/machine.hpp"
#include "support/textbook.hpp"
#include <benchmark/benchmark.h>
#include <numeric>
#include <random>
#include <vector>

namespace tyndall::bench {
using namespace light_shafts;
namespace {
std::vector<float> random_map(std::int64_t size) {
    static const bool has_machine = (add_machine_to_context(), true);
    std::mt19937 random(has_machine ? 1 : 0);
    std::vector<float> map(static_cast<std::size_t>(size * size));
    for (float& value : map)
        value = random() % 4 != 0 ? slope_rows::no_occluder : static_cast<float>(random() % 1024);
    return map;
}
flat_filters::MapSpan span_of(std::vector<float>& map, std::int64_t size) {
    return {map.data(), static_cast<std::int32_t>(size), static_cast<std::int32_t>(size), size};
}

} // namespace

static void close_map(benchmark::State& state, KernelShape shape) {
    const Progress progress;
    std::vector<float> map = random_map(state.range(0));
    for (auto _ : state)
        flat_filters::close_map(span_of(map, state.range(0)), shape, 20.0f, progress);
}
static void close_square(benchmark::State& state) { close_map(state, KernelShape::Square); }
static void close_disc(benchmark::State& state) { close_map(state, KernelShape::Disc); }

template <typename Filter>
static void filter_rows(benchmark::State& state, const Filter& filter) {
    const Progress progress;
    const auto size = static_cast<std::size_t>(state.range(0));
    std::vector<float> map = random_map(state.range(0));
    for (auto _ : state)
        parallel_for(
            size, progress, [&](std::size_t y) { filter(std::span(map).subspan(y * size, size)); }, 16);
}
static void close_rows(benchmark::State& state) {
    filter_rows(state, [](std::span<float> row) { flat_filters::close_row(row, 61); });
}
static void dilate_rows(benchmark::State& state) {
    filter_rows(state, [](std::span<float> row) { flat_filters::dilate_row_forward(row, 60); });
}

static void plain_close_square(benchmark::State& state) {
    std::vector<float> map = random_map(state.range(0)), other(map.size());
    for (auto _ : state)
        textbook::close_square(map, other, state.range(0), 20);
}
static void plain_close_rows(benchmark::State& state) {
    std::vector<float> map = random_map(state.range(0));
    for (auto _ : state)
        textbook::close_rows(map, state.range(0), 30);
}

static void make_holes(benchmark::State& state, float sway, bool is_in_space) {
    const Progress progress;
    const auto size = static_cast<std::size_t>(state.range(0));
    const HoleNoiseField field({.octaves = 5, .persistence = 0.5f, .sway = sway, .turn_rad = 1.0f});
    std::vector<float> x(size), slope(size, 0.5f);
    for (std::size_t i = 0; i < size; ++i)
        x[i] = 0.02f * static_cast<float>(i);
    std::vector<std::uint8_t> is_hole(size * size);
    for (auto _ : state)
        parallel_for(
            size, progress,
            [&](std::size_t row) {
                thread_local std::vector<float> y;
                y.assign(size, x[row]);
                const std::span<std::uint8_t> to = std::span(is_hole).subspan(row * size, size);
                is_in_space ? field.holes(x, y, slope, to) : field.holes(x, y, to);
            },
            16);
    state.counters["share_of_holes"] =
        std::accumulate(is_hole.begin(), is_hole.end(), 0.0) / static_cast<double>(is_hole.size());
}
static void holes(benchmark::State& state) { make_holes(state, 0.0f, false); }
static void moving_holes(benchmark::State& state) { make_holes(state, 1.0f, false); }
static void moving_holes_in_space(benchmark::State& state) { make_holes(state, 1.0f, true); }

static void plain_moving_holes(benchmark::State& state) {
    const textbook::Noise noise;
    const std::int64_t size = state.range(0);
    std::vector<std::uint8_t> is_hole(static_cast<std::size_t>(size * size));
    for (auto _ : state)
        for (std::size_t i = 0; i < is_hole.size(); ++i) {
            // Turned about the corner: coordinates that do not become negative.
            const float x = 0.02f * static_cast<float>(i % static_cast<std::size_t>(size)) + 200.0f,
                        y = 0.02f * static_cast<float>(i / static_cast<std::size_t>(size)) + 2.0f;
            const float move = noise.fractal(0.8f * x - 0.6f * y, 0.6f * x + 0.8f * y);
            is_hole[i] = noise.fractal(x + 0.8f * move, y + 0.6f * move) < -0.1f;
        }
}

#define TYNDALL_EDITS_BENCHMARK(name)                                                                                  \
    BENCHMARK(name)->ArgName("size")->Arg(1024)->Arg(2048)->Arg(4096)->MeasureProcessCPUTime()->UseRealTime()->Unit(   \
        benchmark::kMillisecond)
TYNDALL_EDITS_BENCHMARK(plain_close_square);
TYNDALL_EDITS_BENCHMARK(close_square);
TYNDALL_EDITS_BENCHMARK(close_disc);
TYNDALL_EDITS_BENCHMARK(plain_close_rows);
TYNDALL_EDITS_BENCHMARK(close_rows);
TYNDALL_EDITS_BENCHMARK(dilate_rows);
TYNDALL_EDITS_BENCHMARK(plain_moving_holes);
TYNDALL_EDITS_BENCHMARK(holes);
TYNDALL_EDITS_BENCHMARK(moving_holes);
TYNDALL_EDITS_BENCHMARK(moving_holes_in_space);
} // namespace tyndall::bench
