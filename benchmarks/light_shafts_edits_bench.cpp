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
#include <algorithm>
#include <array>
#include <benchmark/benchmark.h>
#include <cmath>
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

/// Perlin's noise of 1985 as in textbooks: a table of 256 numbers, shuffled, and of as many gradients.
class PlainNoise {
public:
    PlainNoise() {
        std::iota(order_.begin(), order_.begin() + 256, 0);
        std::shuffle(order_.begin(), order_.begin() + 256, std::mt19937(1));
        std::copy_n(order_.begin(), 256, order_.begin() + 256);
        for (std::size_t i = 0; i < 256; ++i)
            gradients_[i] = {std::cos(static_cast<float>(i)), std::sin(static_cast<float>(i))};
    }
    [[nodiscard]] float fractal(float x, float y) const {
        float sum = 0.0f, amplitude = 0.5f;
        for (int octave = 0; octave < 5; ++octave, x *= 2, y *= 2, amplitude *= 0.5f)
            sum += amplitude * at(x, y);
        return sum;
    }

private:
    [[nodiscard]] float at(float x, float y) const {
        const float floor_x = std::floor(x), floor_y = std::floor(y), u = x - floor_x, v = y - floor_y;
        const std::size_t i = static_cast<std::size_t>(floor_x) & 255, j = static_cast<std::size_t>(floor_y) & 255;
        const auto corner = [&](std::size_t di, std::size_t dj, float du, float dv) {
            const vec2 gradient = gradients_[order_[order_[(i + di) & 255] + ((j + dj) & 255)]];
            return gradient.x * du + gradient.y * dv;
        };
        const float fade_u = u * u * u * (u * (6 * u - 15) + 10), fade_v = v * v * v * (v * (6 * v - 15) + 10);
        return std::lerp(std::lerp(corner(0, 0, u, v), corner(1, 0, u - 1, v), fade_u),
                         std::lerp(corner(0, 1, u, v - 1), corner(1, 1, u - 1, v - 1), fade_u), fade_v);
    }
    std::array<std::size_t, 512> order_{};
    std::array<vec2, 256> gradients_{};
};
static void plain_moving_holes(benchmark::State& state) {
    const PlainNoise noise;
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
