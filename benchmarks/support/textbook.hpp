// SPDX-License-Identifier: GPL-3.0-or-later
// What benchmarks compare with: closings and noise as one writes them down, one thread, no SIMD by hand.
#pragma once
#include "core/math.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <random>
#include <span>
#include <vector>

namespace tyndall::bench::textbook {
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
inline constexpr auto largest = [](float a, float b) { return std::max(a, b); };
inline constexpr auto smallest = [](float a, float b) { return std::min(a, b); };

/// Of a square map by a square of 2 reach + 1 texels; `other` is as large as the map.
inline void close_square(std::vector<float>& map, std::vector<float>& other, std::int64_t size, std::int64_t reach) {
    const auto pass = [&](auto extreme) {
        for (std::int64_t y = 0; y < size; ++y)
            plain_extremes(&map[static_cast<std::size_t>(y * size)], &other[static_cast<std::size_t>(y * size)], size,
                           1, reach, reach, extreme);
        for (std::int64_t x = 0; x < size; ++x)
            plain_extremes(&other[static_cast<std::size_t>(x)], &map[static_cast<std::size_t>(x)], size, size, reach,
                           reach, extreme);
    };
    pass(largest);
    pass(smallest);
}
/// Of every row of a square map by 2 reach + 1 texels.
inline void close_rows(std::vector<float>& map, std::int64_t size, std::int64_t reach) {
    std::vector<float> dilated(static_cast<std::size_t>(size));
    for (std::int64_t y = 0; y < size; ++y) {
        float* row = &map[static_cast<std::size_t>(y * size)];
        plain_extremes(row, dilated.data(), size, 1, reach, reach, largest);
        plain_extremes(dilated.data(), row, size, 1, reach, reach, smallest);
    }
}

/// Perlin's noise of 1985 as in textbooks: a table of 256 numbers, shuffled, and of as many gradients.
class Noise {
public:
    Noise() {
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
} // namespace tyndall::bench::textbook
