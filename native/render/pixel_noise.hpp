// SPDX-License-Identifier: GPL-3.0-or-later
// Which pixels of a picture need more samples: those whose mean is still uncertain, and their neighbours.
// Based on: the standard error of the samples so far; relative to the square root of the mean, as Cycles' noise
//           threshold (a middle way between absolute and relative: dark noise shows less than its ratio says).
// Differs:  the variance itself instead of two halves of the samples; decided after whole rounds of samples, so that a
//           pixel that stops early has seen each stratum of the lights as often as any other. Black pixels go on for a while.
// Bound:    12 bytes and a few operations per pixel and sample.
#pragma once
#include "core/math.hpp"
#include "core/progress.hpp"
#include <cstdint>
#include <vector>

namespace tyndall::render {
class PixelNoise {
public:
    /// turn_samples: so many samples differ by which lights were asked, and tell of noise only together.
    PixelNoise(std::uint32_t width_px, std::uint32_t height_px, std::uint32_t turn_samples = 1);
    /// Light of the pixel's current sample. Threads may add to different pixels.
    void add(std::size_t pixel, const Rgb& radiance);
    /// The current sample of the pixels that `is_active` is complete.
    void end_sample(const std::vector<std::uint8_t>& is_active);
    /// Leaves those pixels active whose standard error, or a neighbour's, exceeds threshold * sqrt(mean); returns how
    /// many are left.
    [[nodiscard]] std::size_t keep_noisy(float threshold, std::vector<std::uint8_t>& is_active,
                                         const Progress& progress) const;

private:
    struct Moments {
        float current = 0.0f, sum = 0.0f, sum_of_squares = 0.0f;
        std::uint32_t samples = 0;
    };
    std::uint32_t width_px_, height_px_, turn_samples_;
    std::vector<Moments> pixels_;
};

/// Samples per round: the least divisor of the samples that is at least 4.
[[nodiscard]] std::uint32_t samples_per_round(std::uint32_t pixel_samples);
} // namespace tyndall::render
