// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/pixel_noise.hpp"
#include "core/parallel.hpp"
#include <algorithm>

namespace tyndall::render {
/// A pixel that has met no light yet, as deep in a room before a small window, may still be lit: its variance says nothing.
static constexpr std::uint32_t least_samples_of_black = 16;

PixelNoise::PixelNoise(std::uint32_t width_px, std::uint32_t height_px, std::uint32_t turn_samples)
    : width_px_(width_px), height_px_(height_px), turn_samples_(turn_samples),
      pixels_(std::size_t{width_px} * height_px) {}

void PixelNoise::add(std::size_t pixel, const Rgb& radiance) { pixels_[pixel].current += average(radiance); }

void PixelNoise::end_sample(const std::vector<std::uint8_t>& is_active) {
    for (std::size_t pixel = 0; pixel < pixels_.size(); ++pixel)
        if (is_active[pixel]) {
            Moments& moments = pixels_[pixel];
            if (++moments.samples % turn_samples_ != 0)
                continue;
            const float mean = moments.current / static_cast<float>(turn_samples_);
            moments.sum += mean;
            moments.sum_of_squares += mean * mean;
            moments.current = 0.0f;
        }
}

std::size_t PixelNoise::keep_noisy(float threshold, std::vector<std::uint8_t>& is_active,
                                   const Progress& progress) const {
    std::vector<std::uint8_t> is_noisy(pixels_.size());
    parallel_for(
        pixels_.size(), progress,
        [&](std::size_t pixel) {
            const Moments& moments = pixels_[pixel];
            const auto count = static_cast<float>(moments.samples / turn_samples_);
            const float mean = moments.sum / count;
            const float variance = (moments.sum_of_squares - moments.sum * mean) / std::max(count - 1.0f, 1.0f);
            // A NaN or an infinity has no use for more samples.
            const bool is_uncertain = variance / count > threshold * threshold * std::abs(mean);
            is_noisy[pixel] = is_uncertain || (moments.sum == 0.0f && moments.samples < least_samples_of_black) ? 1 : 0;
        },
        1 << 14);
    const auto width = static_cast<std::int64_t>(width_px_), height = static_cast<std::int64_t>(height_px_);
    return parallel_sum(height_px_, 16, std::size_t{0}, progress, [&](std::size_t begin, std::size_t end) {
        std::size_t count = 0;
        for (auto y = static_cast<std::int64_t>(begin); y < static_cast<std::int64_t>(end); ++y)
            for (std::int64_t x = 0; x < width; ++x) {
                std::uint8_t is_near = 0;
                for (std::int64_t v = std::max<std::int64_t>(y - 1, 0); v <= std::min(y + 1, height - 1); ++v)
                    for (std::int64_t u = std::max<std::int64_t>(x - 1, 0); u <= std::min(x + 1, width - 1); ++u)
                        is_near |= is_noisy[static_cast<std::size_t>(v * width + u)];
                std::uint8_t& active = is_active[static_cast<std::size_t>(y * width + x)];
                active &= is_near;
                count += active;
            }
        return count;
    });
}

std::uint32_t samples_per_round(std::uint32_t pixel_samples) {
    std::uint32_t samples = std::min(pixel_samples, 4u);
    while (pixel_samples % samples != 0)
        ++samples;
    return samples;
}
} // namespace tyndall::render
