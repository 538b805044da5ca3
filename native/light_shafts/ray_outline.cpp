// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/ray_outline.hpp"
#include "core/parallel.hpp"
#include <algorithm>
#include <array>
#include <cmath>

namespace tyndall::light_shafts {
namespace {
constexpr std::size_t most_neighbours = 32;

/// Where a ray lies in the picture: what it does not share with the others.
vec3 place_of(bool is_orthographic, const ViewRay& ray) { return is_orthographic ? ray.origin : ray.direction; }

/// The usual distance of consecutive rays.
float pixel_size(bool is_orthographic, std::span<const ViewRay> rays) {
    std::vector<float> steps;
    const std::size_t stride = 1 + rays.size() / 1024;
    for (std::size_t i = 1; i < rays.size(); i += stride)
        if (const float step =
                glm::distance(place_of(is_orthographic, rays[i]), place_of(is_orthographic, rays[i - 1]));
            step > 0.0f)
            steps.push_back(step);
    if (steps.empty())
        return 0.0f;
    const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
    std::nth_element(steps.begin(), middle, steps.end());
    // Up to the next quarter of an octave: where an object moves, other rays meet media, and the rest stays as it is.
    return std::exp2(std::ceil(4.0f * std::log2(*middle)) / 4.0f);
}

/// Spans end at the borders of cells of directions (of places): a ray that is no more, or is new, changes those of its own
/// cell.
constexpr float pixels_per_cell = 24.0f;

/// Places of up to most_neighbours rays, in columns: loops without an exit run on vectors.
struct Places {
    std::array<float, most_neighbours> x, y, z;
    Places(bool is_orthographic, std::span<const ViewRay> rays) {
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const vec3 place = place_of(is_orthographic, rays[i]);
            x[i] = place.x, y[i] = place.y, z[i] = place.z;
        }
    }
    [[nodiscard]] vec3 at(std::size_t i) const { return {x[i], y[i], z[i]}; }
};

/// How many rays from the first on lie in its cell, and no more than four pixels from the one before.
std::size_t count_neighbours(const Places& places, std::size_t count, float pixel) {
    std::array<int, most_neighbours> is_far{};
    const float per_cell = 1.0f / (pixels_per_cell * pixel);
    for (std::size_t i = 1; i < count; ++i) {
        const float x = places.x[i] - places.x[i - 1], y = places.y[i] - places.y[i - 1],
                    z = places.z[i] - places.z[i - 1];
        const int is_beyond = int{std::floor(places.x[i] * per_cell) != std::floor(places.x[i - 1] * per_cell)} |
                              int{std::floor(places.y[i] * per_cell) != std::floor(places.y[i - 1] * per_cell)} |
                              int{std::floor(places.z[i] * per_cell) != std::floor(places.z[i - 1] * per_cell)};
        is_far[i] = is_beyond | int{!(x * x + y * y + z * z <= 16.0f * pixel * pixel)};
    }
    const auto end = is_far.begin() + static_cast<std::ptrdiff_t>(count);
    return static_cast<std::size_t>(std::find(is_far.begin(), end, 1) - is_far.begin());
}

/// All lie on the way from the first to the last, to a pixel and a half.
bool are_in_line(const Places& places, std::size_t count, float pixel) {
    const vec3 first = places.at(0), way = places.at(count - 1) - first;
    const float length = glm::length(way);
    if (!(length > 0.0f))
        return false;
    const vec3 unit = way / length;
    int strays = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const float x = places.x[i] - first.x, y = places.y[i] - first.y, z = places.z[i] - first.z;
        const float along = x * unit.x + y * unit.y + z * unit.z;
        const float aside_x = x - along * unit.x, aside_y = y - along * unit.y, aside_z = z - along * unit.z;
        const float aside = aside_x * aside_x + aside_y * aside_y + aside_z * aside_z;
        const int is_in_line =
            int{along >= -0.5f * pixel} & int{along <= length + 0.5f * pixel} & int{aside <= 2.25f * pixel * pixel};
        strays |= 1 - is_in_line;
    }
    return strays == 0;
}

RaySpan span_of(bool is_orthographic, std::span<const ViewRay> rays, float pixel) {
    RaySpan span{rays.front(), rays.back()};
    const vec3 pixel_along =
        pixel * glm::normalize(place_of(is_orthographic, span.last) - place_of(is_orthographic, span.first));
    if (is_orthographic) {
        span.first.origin -= pixel_along;
        span.last.origin += pixel_along;
    } else {
        span.first.direction = glm::normalize(span.first.direction - pixel_along);
        span.last.direction = glm::normalize(span.last.direction + pixel_along);
    }
    for (const ViewRay& ray : rays) {
        span.first.near_m = std::min(span.first.near_m, ray.near_m);
        span.first.far_m = std::max(span.first.far_m, ray.far_m);
    }
    span.last.near_m = span.first.near_m;
    span.last.far_m = span.first.far_m;
    return span;
}
} // namespace

/// The first ray from `at` on that is no neighbour of the one before.
static std::size_t next_start(bool is_orthographic, std::span<const ViewRay> rays, std::size_t at, float pixel) {
    while (0 < at && at < rays.size() &&
           count_neighbours(Places(is_orthographic, rays.subspan(at - 1, 2)), 2, pixel) == 2)
        ++at;
    return at;
}

static void append_spans(bool is_orthographic, std::span<const ViewRay> rays, float pixel,
                         std::vector<RaySpan>& spans) {
    for (std::size_t begin = 0, end; begin < rays.size(); begin = end) {
        const auto ahead = rays.subspan(begin, std::min(most_neighbours, rays.size() - begin));
        const Places places(is_orthographic, ahead);
        const std::size_t count = count_neighbours(places, ahead.size(), pixel);
        end = begin + count;
        const auto neighbours = ahead.first(count);
        if (are_in_line(places, count, pixel))
            spans.push_back(span_of(is_orthographic, neighbours, pixel));
        else
            for (const ViewRay& ray : neighbours)
                spans.push_back({ray, ray});
    }
}

std::vector<RaySpan> outline(bool is_orthographic, std::span<const ViewRay> rays, const Progress& progress) {
    constexpr std::size_t rays_per_block = std::size_t{1} << 14;
    const float pixel = pixel_size(is_orthographic, rays);
    std::vector<std::vector<RaySpan>> blocks((rays.size() + rays_per_block - 1) / rays_per_block);
    parallel_blocks(rays.size(), rays_per_block, progress, [&](std::size_t begin, std::size_t end) {
        const std::size_t block = begin / rays_per_block;
        begin = next_start(is_orthographic, rays, begin, pixel), end = next_start(is_orthographic, rays, end, pixel);
        append_spans(is_orthographic, rays.subspan(begin, end - begin), pixel, blocks[block]);
    });
    std::vector<RaySpan> spans;
    for (const auto& block : blocks)
        spans.insert(spans.end(), block.begin(), block.end());
    return spans;
}
} // namespace tyndall::light_shafts
