// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/patterns/gabor.hpp"
#include "shading/patterns/hash.hpp"
#include <algorithm>
#include <numbers>

namespace tyndall::patterns {
namespace {
constexpr int kernels_per_cell = 8;

/// Of the signed kernels' sum: their count per cell, times a kernel's squared integral, times the signs' second moment.
template <int N>
float deviation() {
    const float squared_integral = N == 2 ? 0.25f : 1.0f / (4.0f * std::numbers::sqrt2_v<float>);
    return std::sqrt(static_cast<float>(kernels_per_cell) * 0.5f * squared_integral);
}

/// Where a kernel's stripes lead: turned away from the base by chance, as far as `isotropy` lets it.
vec2 direction_of(const Point<3>& seed, float angle_rad, float isotropy) {
    const float angle = angle_rad + (random(seed) - 0.5f) * pi * isotropy;
    return {std::cos(angle), std::sin(angle)};
}
vec3 direction_of(const Point<4>& seed, const vec3& base, float isotropy) {
    if (isotropy == 0.0f)
        return base;
    const vec2 turned = random_pair(seed) * (pi * isotropy);
    const float across = std::sqrt(base.x * base.x + base.y * base.y);
    const float side = base.y < 0.0f ? -1.0f : 1.0f;
    const float inclination = std::acos(base.z) + turned.x;
    const float azimuth = side * std::acos(across > 0.0f ? base.x / across : 0.0f) + turned.y;
    return {std::sin(inclination) * std::cos(azimuth), std::sin(inclination) * std::sin(azimuth),
            std::cos(inclination)};
}

/// Cosine and sine of the waves around, under their windows.
template <int N, typename Base>
vec2 waves_at(const Point<N>& at, float frequency, float isotropy, const Base& base) {
    const Point<N> own_cell = glm::floor(at), within = at - own_cell;
    vec2 sum(0.0f);
    for (int index = 0; index < (N == 2 ? 9 : 27); ++index) {
        Point<N> offset;
        for (int axis = 0, rest = index; axis < N; ++axis, rest /= 3)
            offset[axis] = static_cast<float>(rest % 3 - 1);
        const Point<N> cell = own_cell + offset;
        for (int kernel = 0; kernel < kernels_per_cell; ++kernel) {
            const auto seed = [&](int which) { return Point<N + 1>(cell, static_cast<float>(kernel * 3 + which)); };
            const auto centre = [&] {
                if constexpr (N == 2)
                    return random_pair(seed(1));
                else
                    return random_colour(seed(1));
            }();
            const Point<N> from_centre = within - offset - centre;
            const float squared = glm::dot(from_centre, from_centre);
            if (squared >= 1.0f)
                continue;
            const float weight = random(seed(2)) < 0.5f ? -1.0f : 1.0f;
            const float window = std::exp(-pi * squared) * (0.5f + 0.5f * std::cos(pi * squared));
            const float angle = 2.0f * pi * glm::dot(from_centre, direction_of(seed(0), base, isotropy) * frequency);
            sum += weight * window * vec2(std::cos(angle), std::sin(angle));
        }
    }
    return sum;
}
} // namespace

Gabor gabor(const vec3& vector, const GaborConfig& config) {
    const vec3 at = vector * config.scale;
    const float isotropy = 1.0f - std::clamp(config.anisotropy, 0.0f, 1.0f);
    const float frequency = std::max(config.frequency, 0.001f);
    vec2 waves;
    float all;
    if (config.dimensions == 2) {
        waves = waves_at<2>(vec2(at), frequency, isotropy, config.angle_rad);
        all = 6.0f * deviation<2>();
    } else {
        waves = waves_at<3>(at, frequency, isotropy, unit_or(config.direction, vec3(0.0f)));
        all = 6.0f * deviation<3>();
    }
    return {.value = waves.y / all * 0.5f + 0.5f,
            .phase = (std::atan2(waves.y, waves.x) + pi) / (2.0f * pi),
            .intensity = glm::length(waves) / all};
}
} // namespace tyndall::patterns
