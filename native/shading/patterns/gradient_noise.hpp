// SPDX-License-Identifier: GPL-3.0-or-later
// Gradient noise in one to four dimensions, several points at a time: the octaves of one point, or its colours.
// Based on: Perlin, Improving Noise, SIGGRAPH 2002: the quintic fade and gradients towards a cube's edges.
// Differs:  a lattice point's gradient comes from a hash of its coordinates (hash.hpp) instead of a permutation, so
//           that the period is 2^32 cells; gradients of one to four dimensions; each dimension has the factor that
//           brings its values to about [-1, 1], as Cycles has it. A corner per lane: 8 corners are summed by their
//           weights. Beyond 100,000 it repeats, as in Blender from 4.0 on; in 3.4 its cells there become the
//           floats themselves.
// Bound:    2^N hashes per point.
#pragma once
#include "shading/patterns/hash.hpp"
#include <span>

namespace tyndall::patterns {
/// About [-1, 1], 0 at lattice points, per point; `values` has a place for each. Coordinates beyond 100,000 repeat; a
/// point that is not finite has 0.
template <int N>
void gradient_noise(std::span<const Point<N>> points, float* values);
template <>
void gradient_noise<1>(std::span<const Point<1>>, float*);
template <>
void gradient_noise<2>(std::span<const Point<2>>, float*);
template <>
void gradient_noise<3>(std::span<const Point<3>>, float*);
template <>
void gradient_noise<4>(std::span<const Point<4>>, float*);

template <int N>
[[nodiscard]] float gradient_noise(const Point<N>& point) {
    float value = 0.0f;
    gradient_noise<N>(std::span<const Point<N>>(&point, 1), &value);
    return value;
}
} // namespace tyndall::patterns
