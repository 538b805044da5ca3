// SPDX-License-Identifier: GPL-3.0-or-later
// The random numbers of one sample of one pixel: well spread over the pixel's samples, unrelated between pixels.
// Based on: Burley, Practical Hash-based Owen Scrambling, JCGT 9(4), 2020: a padded sequence. Each pair is a
//           two-dimensional Sobol sequence over the pixel's samples, shuffled and scrambled by its own hash.
// Bound:    10 ns a pair where many pixels ask at once, three times that alone.
#pragma once
#include "core/sobol.hpp"
#include "scene/camera.hpp"
#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

namespace tyndall::render {
/// By the place in the full frame: a region has the full frame's noise, too.
[[nodiscard]] inline std::uint32_t pixel_seed(const Camera& camera, std::uint32_t seed, std::uint32_t x,
                                              std::uint32_t y) {
    return hash(seed, y * camera.width_px + x);
}
/// Through the pixel's centre, or so far beside it.
[[nodiscard]] inline Ray pixel_ray(const Camera& camera, std::uint32_t x, std::uint32_t y,
                                   const vec2& offset_px = vec2(0.0f)) {
    return camera.ray(static_cast<float>(x) + 0.5f + offset_px.x, static_cast<float>(y) + 0.5f + offset_px.y);
}

/// Pair `pair_index` of sample `sample_index` of a pixel, in [0, 1)^2.
[[nodiscard]] constexpr vec2 pixel_pair(std::uint32_t pixel_seed, std::uint32_t sample_index,
                                        std::uint32_t pair_index) {
    return sobol_point(sample_index, hash(pixel_seed, pair_index));
}

/// A sharp ray of a pixel from elsewhere on the lens.
[[nodiscard]] inline Ray lens_ray(const Camera& camera, const Ray& sharp, std::uint32_t pixel_seed,
                                  std::uint32_t sample_index) {
    constexpr std::uint32_t pair_index = ~1u; // far behind those of lights
    return camera.lens.is_pinhole() ? sharp
                                    : camera.through_lens(sharp, pixel_pair(pixel_seed, sample_index, pair_index));
}

/// What a pixel's ray asks of voxels: cubes as wide as so many pixels are enough.
[[nodiscard]] inline RayDetail ray_detail(const Camera& camera, const Ray& ray, float voxel_detail_px,
                                          std::uint32_t pixel_seed, std::uint32_t sample_index) {
    constexpr std::uint32_t pair_index = ~0u; // far behind those of lights
    RayDetail detail = camera.detail(ray.direction, voxel_detail_px);
    detail.number = pixel_pair(pixel_seed, sample_index, pair_index).x;
    return detail;
}

/// The same pair of up to 16 pixels.
inline void pixel_pairs(std::span<const std::uint32_t> pixel_seeds, std::uint32_t sample_index,
                        std::uint32_t pair_index, std::span<vec2> pairs) {
    // Of a length that the compiler knows, it makes a loop of vector instructions.
    constexpr std::size_t size = 16;
    std::array<std::uint32_t, size> seeds{};
    std::array<vec2, size> points;
    std::copy(pixel_seeds.begin(), pixel_seeds.end(), seeds.begin());
    for (std::size_t i = 0; i < size; ++i)
        points[i] = pixel_pair(seeds[i], sample_index, pair_index);
    std::copy_n(points.begin(), pixel_seeds.size(), pairs.begin());
}
} // namespace tyndall::render
