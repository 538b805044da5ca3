// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/patterns/noise.hpp"
#include "shading/patterns/coordinates.hpp"

namespace tyndall::patterns {
/// Number `seed`'s place elsewhere: each coordinate in [100, 200].
template <int N>
static Point<N> elsewhere(float seed) {
    Point<N> offset;
    for (int axis = 0; axis < N; ++axis)
        offset[axis] = 100.0f + 100.0f * (N == 1 ? random(seed) : random(seed, static_cast<float>(axis)));
    return offset;
}
/// They cost hashes, and never change.
template <int N>
static const std::array<Point<N>, N + 2>& elsewheres() {
    static const std::array<Point<N>, N + 2> all = [] {
        std::array<Point<N>, N + 2> places;
        for (std::size_t seed = 0; seed < places.size(); ++seed)
            places[seed] = elsewhere<N>(static_cast<float>(seed));
        return places;
    }();
    return all;
}

template <int N>
static Point<N> place(const vec3& vector, const NoiseConfig& config) {
    Point<N> point = coordinates<N>(vector, config.w) * config.scale;
    if (config.distortion == 0.0f)
        return point;
    std::array<Point<N>, N> displaced;
    std::array<float, N> by;
    for (std::size_t axis = 0; axis < N; ++axis)
        displaced[axis] = point + elsewheres<N>()[axis];
    gradient_noise<N>(std::span<const Point<N>>(displaced), by.data());
    for (int axis = 0; axis < N; ++axis)
        point[axis] += by[static_cast<std::size_t>(axis)] * config.distortion;
    return point;
}

static Octaves allowed(const NoiseConfig& config) {
    Octaves octaves = config.octaves;
    octaves.detail = std::clamp(octaves.detail, 0.0f, most_detail);
    octaves.factor = std::max(octaves.factor, 0.0f);
    return octaves;
}

template <int N>
static float value_at(const Point<N>& point, const NoiseConfig& config, const Octaves& octaves) {
    return config.fractal == Fractal::Fbm ? fbm<N>(point, octaves, config.is_normalized)
                                          : fractal_noise<N>(config.fractal, point, octaves, 1);
}

float noise(const vec3& vector, const NoiseConfig& config) {
    return with_dimensions(config.dimensions,
                           [&]<int N>() { return value_at<N>(place<N>(vector, config), config, allowed(config)); });
}

Rgb noise_colour(const vec3& vector, const NoiseConfig& config) {
    return with_dimensions(config.dimensions, [&]<int N>() {
        const Point<N> point = place<N>(vector, config);
        const Octaves octaves = allowed(config);
        return Rgb(value_at<N>(point, config, octaves), value_at<N>(point + elsewheres<N>()[N], config, octaves),
                   value_at<N>(point + elsewheres<N>()[N + 1], config, octaves));
    });
}
} // namespace tyndall::patterns
