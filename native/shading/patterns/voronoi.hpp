// SPDX-License-Identifier: GPL-3.0-or-later
// The Voronoi node: distances to points strewn one per cell, in one to four dimensions.
// Based on: Worley, A Cellular Texture Basis Function, SIGGRAPH 1996; Quilez, Voronoi edges (2012) and Smooth Voronoi
//           (2014).
// Differs:  sees the cells next to the place's own (two away for the smooth kind) and no others: with randomness 1 a
//           point further off is sometimes nearer, and missed, as in Cycles. Octaves of cells from Blender 4.0 on;
//           points' places come from another hash from 5.0 on; 3.4 knows no distance beyond 8, and blends with it.
// Bound:    the points of 3^N cells per octave, of 5^N for the smooth kind (points_around.hpp).
#pragma once
#include "core/math.hpp"
#include <cstdint>

namespace tyndall::patterns {
struct VoronoiConfig {
    enum class Feature : std::uint8_t { F1 = 0, F2 = 1, SmoothF1 = 2, DistanceToEdge = 3, SphereRadius = 4 };
    enum class Metric : std::uint8_t { Euclidean = 0, Manhattan = 1, Chebychev = 2, Minkowski = 3 };
    int dimensions = 3; ///< 1 to 4
    Feature feature = Feature::F1;
    Metric metric = Metric::Euclidean;
    bool is_normalized = false;
    bool has_permuted_points = false; ///< Blender 5.0's, in two to four dimensions.
    bool begins_far = false;          ///< Blender 3's: nothing is further than 8, and the smooth kind starts there.
    bool has_colour = true;           ///< Else it is black, and costs nothing.
    float w = 0.0f, scale = 5.0f, randomness = 1.0f, smoothness = 1.0f, exponent = 0.5f;
    float detail = 0.0f, roughness = 0.5f, lacunarity = 2.0f;
};
struct Voronoi {
    float distance = 0.0f; ///< Or the radius.
    Rgb colour{0.0f};
    vec4 place{0.0f}; ///< Of the point, in the vector's units; in one dimension w.
};
[[nodiscard]] Voronoi voronoi(const vec3& vector, const VoronoiConfig& config);
} // namespace tyndall::patterns
