// SPDX-License-Identifier: GPL-3.0-or-later
// Edits of occluders on maps of 1024^2, 2048^2 and 4096^2 texels, as in the tables of Kol 2018, section 5.5.
//   close_square, close_disc     closing by a kernel 41 texels wide       plain_close_*   the same, a texel at a time:
//   close_rows                   closing of length 61 along every row                     two separable passes of 41 (61)
//   dilate_rows                  silhouettes drawn out by 60 samples                      comparisons, no SIMD, one thread
// In place, over and over: a closing costs the same whatever the map holds.
#include "core/parallel.hpp"
#include "light_shafts/flat_filters.hpp"
#include "light_shafts/slope_rows.hpp"
#include "support/machine.hpp"
#include <benchmark/benchmark.h>
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

/// Extremes of `before` values before each and `after` behind it, `step` apart.
template <typename Extreme>
void plain_extremes(const float* from, float* to, std::int64_t count, std::int64_t step, std::int64_t before,
                    std::int64_t after, Extreme extreme) {
    for (std::int64_t i = 0; i < count; ++i) {
        float result = from[i * step];
        for (std::int64_t j = std::max<std::int64_t>(i - before, 0); j <= std::min(i + after, count - 1); ++j)
            result = extreme(result, from[j * step]);
        to[i * step] = result;
    }
}
constexpr auto largest = [](float a, float b) { return std::max(a, b); };
constexpr auto smallest = [](float a, float b) { return std::min(a, b); };
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
    const std::int64_t size = state.range(0);
    std::vector<float> map = random_map(size), other(map.size());
    for (auto _ : state) {
        const auto pass = [&](auto extreme) {
            for (std::int64_t y = 0; y < size; ++y)
                plain_extremes(&map[static_cast<std::size_t>(y * size)], &other[static_cast<std::size_t>(y * size)],
                               size, 1, 20, 20, extreme);
            for (std::int64_t x = 0; x < size; ++x)
                plain_extremes(&other[static_cast<std::size_t>(x)], &map[static_cast<std::size_t>(x)], size, size, 20,
                               20, extreme);
        };
        pass(largest);
        pass(smallest);
    }
}
static void plain_close_rows(benchmark::State& state) {
    const std::int64_t size = state.range(0);
    std::vector<float> map = random_map(size), dilated(static_cast<std::size_t>(size));
    for (auto _ : state)
        for (std::int64_t y = 0; y < size; ++y) {
            float* row = &map[static_cast<std::size_t>(y * size)];
            plain_extremes(row, dilated.data(), size, 1, 30, 30, largest);
            plain_extremes(dilated.data(), row, size, 1, 30, 30, smallest);
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
} // namespace tyndall::bench
