// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/patterns/voronoi.hpp"
#include "shading/patterns/coordinates.hpp"
#include "shading/patterns/fractal_noise.hpp"
#include "shading/patterns/voronoi_cells.hpp"

namespace tyndall::patterns {
namespace {
using Feature = VoronoiConfig::Feature;

VoronoiConfig allowed(VoronoiConfig config) {
    config.detail = std::clamp(config.detail, 0.0f, most_detail);
    config.roughness = std::clamp(config.roughness, 0.0f, 1.0f);
    config.randomness = std::clamp(config.randomness, 0.0f, 1.0f);
    config.smoothness = std::clamp(config.smoothness * 0.5f, 0.0f, 0.5f);
    if (config.feature == Feature::SmoothF1 && config.smoothness == 0.0f && !config.begins_far)
        config.feature = Feature::F1;
    return config;
}

/// What normalized distances are divided by.
template <int N>
float longest(const VoronoiConfig& config) {
    const float half = 0.5f + 0.5f * config.randomness;
    if (config.feature == Feature::DistanceToEdge)
        return half;
    const float diagonal = distance_between(Point<N>(0.0f), Point<N>(half), config);
    return config.feature == Feature::F2 ? 2.0f * diagonal : diagonal;
}

float mix(float a, float b, float share) { return (1.0f - share) * a + share * b; }

/// Calls visit(share) for each octave, its share being 1 but of the last one.
template <typename Visit>
void for_each_octave(const VoronoiConfig& config, const Visit& visit) {
    const float rest = config.detail - std::floor(config.detail);
    for (int octave = 0; static_cast<float>(octave) <= config.detail; ++octave)
        visit(1.0f);
    if (rest != 0.0f)
        visit(rest);
}

template <int N>
Found<N> octaves_of_points(const Point<N>& place, const VoronoiConfig& config) {
    if (config.detail == 0.0f || config.roughness == 0.0f)
        return nearest<N>(place, config);
    Found<N> all;
    float strength = 1.0f, all_strengths = 0.0f, scale = 1.0f;
    for_each_octave(config, [&](float share) {
        const Found<N> octave = nearest<N>(place * scale, config);
        all_strengths += share * strength;
        all.distance += share * strength * octave.distance;
        all.colour += share * strength * octave.colour;
        all.place += share * strength * (octave.place / scale - all.place);
        scale *= config.lacunarity;
        strength *= config.roughness;
    });
    if (config.is_normalized) {
        all.distance /= all_strengths;
        all.colour /= all_strengths;
    }
    return all;
}

template <int N>
float octaves_of_edges(const Point<N>& place, const VoronoiConfig& config) {
    const float of_one = config.is_normalized ? longest<N>(config) : 1.0f;
    if (config.detail == 0.0f || config.roughness == 0.0f)
        return distance_to_edge<N>(place, config) / of_one;
    float distance = 8.0f, strength = 1.0f, scale = 1.0f, longest_of_all = of_one;
    for_each_octave(config, [&](float share) {
        const float octave = distance_to_edge<N>(place * scale, config) / scale;
        const float with = mix(distance, std::min(distance, octave), strength);
        const float longest_with = mix(longest_of_all, of_one / scale, strength);
        distance = share == 1.0f ? with : mix(distance, std::min(distance, with), share);
        longest_of_all = share == 1.0f ? longest_with : mix(longest_of_all, longest_with, share);
        scale *= config.lacunarity;
        strength *= config.roughness;
    });
    return config.is_normalized ? distance / longest_of_all : distance;
}

template <int N>
Voronoi voronoi_in(const vec3& vector, const VoronoiConfig& config) {
    const Point<N> place = coordinates<N>(vector, config.w) * config.scale;
    if (config.feature == Feature::DistanceToEdge)
        return {.distance = octaves_of_edges<N>(place, config)};
    if (config.feature == Feature::SphereRadius)
        return {.distance = sphere_radius<N>(place, config)};
    const Found<N> found = octaves_of_points<N>(place, config);
    Voronoi result{.distance = config.is_normalized ? found.distance / longest<N>(config) : found.distance,
                   .colour = found.colour};
    for (int axis = 0; axis < N && config.scale != 0.0f; ++axis)
        result.place[N == 1 ? 3 : axis] = found.place[axis] / config.scale;
    return result;
}
} // namespace

Voronoi voronoi(const vec3& vector, const VoronoiConfig& config) {
    return with_dimensions(config.dimensions, [&]<int N>() { return voronoi_in<N>(vector, allowed(config)); });
}
} // namespace tyndall::patterns
