// SPDX-License-Identifier: GPL-3.0-or-later
// The vector loop that looks a painted volume up along a ray, dispatched at run time to the best SIMD target of the machine.
// Bound:    16 points at a time: 8 loads of each, and 40 operations.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

namespace tyndall::painted {
struct VolumeRay {
    const float* values; ///< x fastest.
    std::array<std::uint32_t, 3> size;
    std::array<float, 3> origin, direction; ///< In voxels from the middle of the first one, and per metre.
};
/// Trilinear; beyond the outermost samples their values hold. Where no point of a vector has a weight, values stay.
void sample_along(const VolumeRay& ray, const float* at_m, const float* weights, std::size_t count, float* values);
} // namespace tyndall::painted
