// SPDX-License-Identifier: GPL-3.0-or-later
// The vector loop that sums noise along a ray, dispatched at run time to the best SIMD target of the machine.
// Bound:    16 steps at a time: 70 operations and 16 loads of 8 bytes. A level's texels are read in whole: the 8 of a
//           trilinear look-up lie side by side, a byte each, once per texel. Shares of texels are rounded to 1/128.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

namespace tyndall::air_noise {
/// The 8 corners of each cell of a level, x first, from the lowest byte on.
struct PackedLevel {
    std::uint32_t first; ///< Cell of the level, in corners.
    std::uint32_t side_bits;
    float scale; ///< 1 / mean(N).
};
/// Steps of one ray, of which those without weight are passed over.
struct NoiseRay {
    const std::uint64_t* corners;
    std::array<PackedLevel, 2> levels; ///< A step is of the second one where sequence + second_share >= 1.
    float second_share;
    std::array<float, 3> origin, direction; ///< In cubes, and per metre.
    const float* at_m;
    const float* weights;
    const float* sequence;
    const std::uint8_t* level_of_step = nullptr; ///< Into all_levels, where each step has its own.
    const PackedLevel* all_levels = nullptr;
    std::size_t count;
};
struct NoiseSums {
    float weights, noise; ///< Of the weights, and of weight * N / mean(N).
};
[[nodiscard]] NoiseSums sum_along(const NoiseRay& ray);
/// N / mean(N) of each step, whatever its weight.
void find_along(const NoiseRay& ray, float* values);
} // namespace tyndall::air_noise
