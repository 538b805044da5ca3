// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/flat_filters.hpp"
#include "core/parallel.hpp"
#include "light_shafts/flat_filters_kernel.hpp"
#include "light_shafts/row_extremes_kernel.hpp"
#include "light_shafts/slope_rows.hpp"
#include <algorithm>
#include <cmath>
#include <hwy/aligned_allocator.h>
#include <limits>
#include <memory>

namespace tyndall::light_shafts::flat_filters {
/// What neither the largest nor the smallest of some values ever is.
static float neutral(bool is_dilation) {
    return is_dilation ? slope_rows::no_occluder : std::numeric_limits<float>::infinity();
}

/// Memory of this thread for as many floats, aligned for vectors; it keeps what was there, and lives until the next call.
static float* scratch_of(std::size_t count) {
    thread_local hwy::AlignedFreeUniquePtr<float[]> scratch;
    thread_local std::size_t capacity = 0;
    if (capacity < count) {
        scratch = hwy::AllocateAligned<float>(count);
        require(scratch != nullptr, "no memory for a filter of ", count, " floats");
        capacity = count;
    }
    return scratch.get();
}
static std::size_t aligned(std::size_t count) { return (count + 15) / 16 * 16; }

void close_row(std::span<float> row, std::int32_t length) {
    const std::size_t count = row.size();
    if (length < 2 || count < 2)
        return;
    // Centres of windows are samples, or half way between two: one less.
    const bool is_even = length % 2 == 0;
    const std::size_t half = std::min(static_cast<std::size_t>(length) / 2, count - 1);
    const Window window{.before = is_even ? half - 1 : half, .after = half};
    close_along(row.data(), count, window, is_even ? count - 1 : count,
                scratch_of(row_scratch_size(count, window.width())));
}

void dilate_row_forward(std::span<float> row, std::int32_t reach) {
    if (reach < 1 || row.size() < 2)
        return;
    const Window window{.before = std::min(static_cast<std::size_t>(reach), row.size() - 1), .after = 0};
    extremes_along(true, row.data(), row.size(), window, scratch_of(row_scratch_size(row.size(), window.width())));
}

/// Extremes of `half` texels to either side and the one between them.
static void running_extreme_of_rows(bool is_dilation, MapSpan map, std::size_t half, const Progress& progress) {
    const auto width = static_cast<std::size_t>(map.width);
    const std::size_t rows_together = std::max<std::size_t>(1, 32768 / width);
    parallel_blocks(static_cast<std::size_t>(map.height), rows_together, progress,
                    [&](std::size_t begin, std::size_t end) {
                        const Window window{.before = half, .after = half};
                        float* scratch = scratch_of(row_scratch_size(width, window.width()));
                        for (std::size_t y = begin; y < end; ++y)
                            extremes_along(is_dilation, map.values + static_cast<std::ptrdiff_t>(y) * map.stride, width,
                                           window, scratch);
                    });
}

static void close_columns(MapSpan map, std::size_t half, const Progress& progress) {
    const auto width = static_cast<std::size_t>(map.width), height = static_cast<std::size_t>(map.height);
    const std::size_t padding = half * strip_width, size = height * strip_width;
    parallel_blocks(width, strip_width, progress, [&](std::size_t begin, std::size_t end) {
        float* lines = scratch_of(size + 2 * padding);
        float* middle = lines + padding;
        std::fill(lines, middle, neutral(true));
        for (std::size_t y = 0; y < height; ++y)
            std::copy_n(map.values + static_cast<std::ptrdiff_t>(y) * map.stride + begin, end - begin,
                        middle + y * strip_width);
        std::fill(middle + size, middle + size + padding, neutral(true));
        running_extreme_down(true, lines, height, 2 * half + 1);
        // The dilated lines lie at the beginning: the erosion's padding goes below them, and they move.
        std::move_backward(lines, lines + size, middle + size);
        std::fill(lines, middle, neutral(false));
        std::fill(middle + size, middle + size + padding, neutral(false));
        running_extreme_down(false, lines, height, 2 * half + 1);
        for (std::size_t y = 0; y < height; ++y)
            std::copy_n(lines + y * strip_width, end - begin,
                        map.values + static_cast<std::ptrdiff_t>(y) * map.stride + begin);
    });
}

static void close_by_square(MapSpan map, float radius_texels, const Progress& progress) {
    const float most = static_cast<float>(std::max(map.width, map.height));
    const auto half = static_cast<std::size_t>(std::round(std::min(radius_texels, most)));
    const std::size_t across = std::min(half, static_cast<std::size_t>(map.width) - 1),
                      down = std::min(half, static_cast<std::size_t>(map.height) - 1);
    // A square is a row of columns: across, down, down, across; the two in the middle stay in the cache.
    running_extreme_of_rows(true, map, across, progress);
    close_columns(map, down, progress);
    running_extreme_of_rows(false, map, across, progress);
}

/// Texels no farther away than the radius, as far as a map of this size can hold them.
static Disc make_disc(const MapSpan& map, float radius_texels) {
    const double diagonal = std::hypot(double(map.width), double(map.height));
    const double radius = std::min(double{radius_texels}, diagonal), square = radius * radius;
    const auto limit = static_cast<std::size_t>(map.width) - 1;
    Disc disc;
    disc.radius = std::min(static_cast<std::size_t>(radius), static_cast<std::size_t>(map.height) - 1);
    for (std::size_t dy = 0; dy <= disc.radius; ++dy) {
        auto half = static_cast<std::size_t>(std::sqrt(square - double(dy * dy)));
        while (half > 0 && double(half * half + dy * dy) > square)
            --half;
        half = std::min(half, limit);
        if (disc.half_widths.empty() || disc.half_widths.back() != half)
            disc.half_widths.push_back(half);
        disc.of_row.push_back(disc.half_widths.size() - 1);
    }
    return disc;
}

/// Texels [x_begin, x_begin + disc_tile_width) of rows [y_begin, y_end) of `to` become extremes of `from` under the disc.
static void filter_tile(bool is_dilation, const MapSpan& from, const MapSpan& to, const Disc& disc,
                        std::ptrdiff_t x_begin, std::ptrdiff_t y_begin, std::ptrdiff_t y_end) {
    const auto radius = static_cast<std::ptrdiff_t>(disc.radius),
               reach = static_cast<std::ptrdiff_t>(disc.half_widths[0]);
    const std::ptrdiff_t x_end = std::min<std::ptrdiff_t>(x_begin + disc_tile_width, from.width);
    const std::ptrdiff_t x_first = std::max<std::ptrdiff_t>(x_begin - reach, 0),
                         x_last = std::min<std::ptrdiff_t>(x_begin + disc_tile_width + reach, from.width);
    constexpr std::ptrdiff_t rows_ahead = 6;
    const float nothing = neutral(is_dilation);
    thread_local DoubledRow row;
    thread_local std::vector<float*> outputs;
    row.stride = aligned(disc_tile_width + 2 * disc.half_widths[0] + row_slack);
    row.values.assign(row.stride * static_cast<std::size_t>(std::bit_width(2 * disc.half_widths[0] + 1)), nothing);
    // One line for each row that the row at hand reaches; that of the row which it reaches last is the next one's first.
    const std::ptrdiff_t line_count = 2 * radius + 1;
    // Lines a power of two apart would seem to overlap to a CPU that compares the last 12 bits of addresses.
    constexpr std::ptrdiff_t line_stride = disc_tile_width + 16;
    float* lines = scratch_of(static_cast<std::size_t>(line_count * line_stride));
    // The lines take turns: outputs[radius + dy] is that of row y + dy.
    outputs.resize(static_cast<std::size_t>(line_count));
    for (std::ptrdiff_t line = 0; line < line_count; ++line)
        outputs[static_cast<std::size_t>(line)] = lines + line * line_stride;
    std::fill_n(lines, line_count * line_stride, nothing);
    for (std::ptrdiff_t y = y_begin - radius; y < y_end + radius; ++y) {
        if (0 <= y && y < from.height) {
            const float* texels = from.values + y * from.stride;
            // Rows lie in different pages, across which the CPU does not look ahead by itself.
            if (y + rows_ahead < from.height)
                for (std::ptrdiff_t x = x_first; x < x_last; x += 16)
                    __builtin_prefetch(texels + rows_ahead * from.stride + x);
            std::copy(texels + x_first, texels + x_last, row.values.data() + (x_first - (x_begin - reach)));
            spread_row(is_dilation, disc, row, outputs.data());
        }
        float* complete = outputs[0]; // no later row reaches it
        if (y - radius >= y_begin)
            std::copy_n(complete, x_end - x_begin, to.values + (y - radius) * to.stride + x_begin);
        std::copy(outputs.begin() + 1, outputs.end(), outputs.begin());
        outputs.back() = complete;
        std::fill_n(complete, disc_tile_width, nothing);
    }
}

static void filter_by_disc(bool is_dilation, const MapSpan& from, const MapSpan& to, const Disc& disc,
                           const Progress& progress) {
    // Tall tiles: the rows above and below one are filtered for it alone.
    const std::size_t tile_height = std::max<std::size_t>(256, 8 * disc.radius);
    const std::size_t height = static_cast<std::size_t>(from.height), width = static_cast<std::size_t>(from.width);
    const std::size_t columns = (width + disc_tile_width - 1) / disc_tile_width;
    parallel_for(
        columns * ((height + tile_height - 1) / tile_height), progress,
        [&](std::size_t tile) {
            const std::size_t y = tile / columns * tile_height;
            filter_tile(is_dilation, from, to, disc, static_cast<std::ptrdiff_t>(tile % columns * disc_tile_width),
                        static_cast<std::ptrdiff_t>(y), static_cast<std::ptrdiff_t>(std::min(y + tile_height, height)));
        },
        1);
}

void close_map(MapSpan map, KernelShape shape, float radius_texels, const Progress& progress) {
    require_in(radius_texels, 0.0f, std::numeric_limits<float>::infinity(), "radius_texels");
    if (radius_texels < 0.5f || map.width < 1 || map.height < 1)
        return;
    if (shape == KernelShape::Square) {
        close_by_square(map, radius_texels, progress);
        return;
    }
    const Disc disc = make_disc(map, radius_texels);
    if (disc.half_widths[0] == 0 && disc.radius == 0)
        return;
    const std::unique_ptr<float[]> values = std::make_unique_for_overwrite<float[]>(
        static_cast<std::size_t>(map.width) * static_cast<std::size_t>(map.height));
    const MapSpan dilated{.values = values.get(), .width = map.width, .height = map.height, .stride = map.width};
    filter_by_disc(true, map, dilated, disc, progress);
    filter_by_disc(false, dilated, map, disc, progress);
}
} // namespace tyndall::light_shafts::flat_filters
