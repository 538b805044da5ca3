// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/shared_irradiance.hpp"
#include <algorithm>
#include <cstdlib>

namespace tyndall::render {
std::uint32_t shared_reach_px(std::uint64_t rays_per_pixel) {
    return rays_per_pixel <= 16 ? 2 : rays_per_pixel <= 64 ? 1 : 0;
}

bool is_coplanar(const WorldLit& a, const WorldLit& b) {
    constexpr float least_cosine = 0.95f, most_sine = 0.2f;
    if (glm::dot(a.normal, b.normal) < least_cosine)
        return false;
    const vec3 way = b.position - a.position;
    const float out_of_plane = glm::dot(a.normal, way);
    return out_of_plane * out_of_plane <= most_sine * most_sine * glm::dot(way, way);
}

Rgb shared_light_gain(std::span<const WorldLit> pixels, std::uint32_t width_px, std::uint32_t reach_px, std::uint32_t x,
                      std::uint32_t y) {
    const auto reach = static_cast<std::int64_t>(reach_px), width = static_cast<std::int64_t>(width_px),
               height = static_cast<std::int64_t>(pixels.size()) / width;
    const auto x0 = static_cast<std::int64_t>(x), y0 = static_cast<std::int64_t>(y);
    const WorldLit& own = pixels[static_cast<std::size_t>(y0 * width + x0)];
    if (own.albedo == Rgb(0.0f))
        return Rgb(0.0f);
    const auto share_of = [&](std::int64_t offset) { return std::abs(offset) == reach ? 0.5f : 1.0f; };
    Rgb sum(0.0f);
    float weight_sum = 0.0f;
    for (std::int64_t v = std::max<std::int64_t>(y0 - reach, 0); v <= std::min(y0 + reach, height - 1); ++v)
        for (std::int64_t u = std::max<std::int64_t>(x0 - reach, 0); u <= std::min(x0 + reach, width - 1); ++u) {
            const WorldLit& other = pixels[static_cast<std::size_t>(v * width + u)];
            if (other.albedo == Rgb(0.0f) || !is_coplanar(own, other))
                continue;
            const float weight = share_of(u - x0) * share_of(v - y0);
            sum += weight * other.irradiance;
            weight_sum += weight;
        }
    return own.albedo * (sum / weight_sum - own.irradiance); // the pixel is in its own plane
}
} // namespace tyndall::render
