// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/ray_outline.hpp"
#include "core/parallel.hpp"
#include <algorithm>

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
    return *middle;
}

/// All lie on the way from the first to the last, to a pixel and a half.
bool are_in_line(bool is_orthographic, std::span<const ViewRay> rays, float pixel) {
    const vec3 first = place_of(is_orthographic, rays.front()), way = place_of(is_orthographic, rays.back()) - first;
    const float length = glm::length(way);
    if (!(length > 0.0f))
        return false;
    const vec3 unit = way / length;
    return std::ranges::all_of(rays, [&](const ViewRay& ray) {
        const vec3 offset = place_of(is_orthographic, ray) - first;
        const float along = glm::dot(offset, unit);
        const vec3 aside = offset - along * unit;
        return along >= -0.5f * pixel && along <= length + 0.5f * pixel &&
               glm::dot(aside, aside) <= 2.25f * pixel * pixel;
    });
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

static void append_spans(bool is_orthographic, std::span<const ViewRay> rays, float pixel,
                         std::vector<RaySpan>& spans) {
    const auto is_next = [&](std::size_t i) {
        const vec3 step = place_of(is_orthographic, rays[i]) - place_of(is_orthographic, rays[i - 1]);
        return glm::dot(step, step) <= 16.0f * pixel * pixel;
    };
    for (std::size_t begin = 0, end; begin < rays.size(); begin = end) {
        end = begin + 1;
        while (end < rays.size() && end - begin < most_neighbours && is_next(end))
            ++end;
        const auto neighbours = rays.subspan(begin, end - begin);
        if (are_in_line(is_orthographic, neighbours, pixel))
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
        append_spans(is_orthographic, rays.subspan(begin, end - begin), pixel, blocks[begin / rays_per_block]);
    });
    std::vector<RaySpan> spans;
    for (const auto& block : blocks)
        spans.insert(spans.end(), block.begin(), block.end());
    return spans;
}
} // namespace tyndall::light_shafts
