// SPDX-License-Identifier: GPL-3.0-or-later
// The White Noise node: nothing but hashes.
// Based on: hash.hpp.
// Differs:  no.
#pragma once
#include "shading/patterns/coordinates.hpp"

namespace tyndall::patterns {
[[nodiscard]] inline float white_noise(const vec3& vector, float w, int dimensions) {
    return with_dimensions(dimensions, [&]<int N>() { return random(coordinates<N>(vector, w)); });
}
[[nodiscard]] inline Rgb white_noise_colour(const vec3& vector, float w, int dimensions) {
    return with_dimensions(dimensions, [&]<int N>() { return random_colour(coordinates<N>(vector, w)); });
}
} // namespace tyndall::patterns
