// SPDX-License-Identifier: GPL-3.0-or-later
// The Gabor node of Blender from 4.3 on: stripes of one frequency, whose phase wanders.
// Based on: Lagae et al., Procedural Noise using Sparse Gabor Convolution, SIGGRAPH 2009; Tavernier et al., Making
//           Gabor Noise Fast and Normalized, Eurographics 2019; Tricard et al., Procedural Phasor Noise, SIGGRAPH
//           2019.
// Differs:  eight kernels per cell instead of a Poisson number, each with a sign; a Gaussian under a Hann window
//           reaches just as far as a cell; values are divided by six deviations.
// Bound:    8 * 3^N hashes of centres; the kernels that reach the place: about 25 in the plane, 34 in space.
#pragma once
#include "core/math.hpp"

namespace tyndall::patterns {
struct GaborConfig {
    int dimensions = 2; ///< 2 or 3
    float scale = 5.0f, frequency = 2.0f, anisotropy = 1.0f, angle_rad = 0.78539816f;
    vec3 direction{1.41421356f, 1.41421356f, 0.0f};
};
struct Gabor {
    float value, phase, intensity; ///< About [0, 1]; turns; at least 0.
};
[[nodiscard]] Gabor gabor(const vec3& vector, const GaborConfig& config);
} // namespace tyndall::patterns
