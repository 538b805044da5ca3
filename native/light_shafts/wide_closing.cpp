// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/wide_closing.hpp"
#include "core/parallel.hpp"
#include <algorithm>
#include <cmath>
#include <vector>

namespace tyndall::light_shafts {
using flat_filters::MapSpan;

namespace {
struct CoarseMap {
    std::int32_t width, height;
    std::vector<float> values;
    [[nodiscard]] MapSpan span() { return {values.data(), width, height, width}; }
};
} // namespace

/// The largest value of each square of step x step texels: nothing that casts a shadow is lost.
static CoarseMap coarsen(const MapSpan& map, std::int32_t step, const Progress& progress) {
    CoarseMap coarse{(map.width + step - 1) / step, (map.height + step - 1) / step, {}};
    coarse.values.resize(static_cast<std::size_t>(coarse.width) * static_cast<std::size_t>(coarse.height));
    parallel_for(
        static_cast<std::size_t>(coarse.height), progress,
        [&](std::size_t row) {
            float* into = &coarse.values[row * static_cast<std::size_t>(coarse.width)];
            const auto first_y = static_cast<std::int32_t>(row) * step;
            std::fill_n(into, coarse.width, -std::numeric_limits<float>::infinity());
            for (std::int32_t y = first_y; y < std::min(first_y + step, map.height); ++y) {
                const float* from = map.values + y * map.stride;
                for (std::int32_t x = 0; x < map.width; ++x)
                    into[x / step] = std::max(into[x / step], from[x]);
            }
        },
        1);
    return coarse;
}

/// The smallest value of each texel and its eight neighbours: takes back what squares have added around occluders.
static CoarseMap eroded(const CoarseMap& map, const Progress& progress) {
    CoarseMap result{map.width, map.height, std::vector<float>(map.values.size())};
    parallel_for(
        static_cast<std::size_t>(map.height), progress,
        [&](std::size_t row) {
            const auto y = static_cast<std::int32_t>(row);
            for (std::int32_t x = 0; x < map.width; ++x) {
                float least = std::numeric_limits<float>::infinity();
                for (std::int32_t v = std::max(y - 1, 0); v <= std::min(y + 1, map.height - 1); ++v)
                    for (std::int32_t u = std::max(x - 1, 0); u <= std::min(x + 1, map.width - 1); ++u)
                        least = std::min(least, map.values[static_cast<std::size_t>(v * map.width + u)]);
                result.values[row * static_cast<std::size_t>(map.width) + static_cast<std::size_t>(x)] = least;
            }
        },
        1);
    return result;
}

void close_wide(MapSpan map, KernelShape shape, float radius_texels, const Progress& progress) {
    if (!(radius_texels > widest_exact_radius_texels)) {
        flat_filters::close_map(map, shape, radius_texels, progress);
        return;
    }
    // A step that leaves the whole map a texel or two is as coarse as can be.
    const auto largest = static_cast<float>(std::max({map.width, map.height, 2}) / 2);
    const auto step =
        static_cast<std::int32_t>(std::min(std::ceil(radius_texels / widest_exact_radius_texels), largest));
    CoarseMap coarse = coarsen(map, step, progress);
    flat_filters::close_map(coarse.span(), shape, radius_texels / static_cast<float>(step), progress);
    coarse = eroded(coarse, progress);
    parallel_for(
        static_cast<std::size_t>(map.height), progress,
        [&](std::size_t row) {
            const auto y = static_cast<std::int32_t>(row);
            const float* from = &coarse.values[static_cast<std::size_t>(y / step * coarse.width)];
            float* into = map.values + y * map.stride;
            for (std::int32_t x = 0; x < map.width; ++x)
                into[x] = std::max(into[x], from[x / step]);
        },
        16);
}
} // namespace tyndall::light_shafts
