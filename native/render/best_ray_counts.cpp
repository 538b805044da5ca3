// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/best_ray_counts.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall::render {
static constexpr std::uint32_t most_rays = 16;
/// Of the noise in a fixed time, that all turns together save: fewer rays make shadows' edges coarser.
static constexpr double least_saving_of_turns = 0.08;

namespace {
/// Up to a factor, the mean standard error of a pixel in a fixed time, as the rays of lights become more or fewer.
class NoiseInTime {
public:
    /// Of a pixel, what one more sample with or without a light changes its variance by.
    using VarianceOf = double (*)(const PixelVariances& pixel, std::size_t light);

    /// Lights beyond the counts have one ray.
    NoiseInTime(std::span<const PixelVariances> pixels, const RayCosts& costs, std::span<const std::uint32_t> counts,
                VarianceOf variance_of)
        : pixels_(pixels), variance_of_(variance_of), cost_(costs.of_camera) {
        const auto count = [&](std::size_t light) { return light < counts.size() ? counts[light] : 1; };
        for (std::size_t light = 0; light < costs.of_light.size(); ++light)
            cost_ += costs.of_light[light] * count(light);
        for (const PixelVariances& pixel : pixels) {
            variances_.push_back(pixel.of_camera);
            for (std::size_t light = 0; light < pixel.of_light.size(); ++light)
                variances_.back() += pixel.of_light[light] / count(light);
        }
        now_ = with(0, 0.0, 0.0);
    }

    [[nodiscard]] double now() const { return now_; }
    /// Takes so much more of a light's variance, at so much more cost, where that leaves at most `share` of the noise.
    bool take_if(std::size_t light, double variance_gain, double more_cost, double share) {
        const double then = with(light, variance_gain, more_cost);
        if (then >= share * now_)
            return false;
        for (std::size_t pixel = 0; pixel < pixels_.size(); ++pixel)
            variances_[pixel] += variance_gain * variance_of_(pixels_[pixel], light);
        cost_ += more_cost;
        now_ = then;
        return true;
    }

private:
    [[nodiscard]] double with(std::size_t light, double variance_gain, double more_cost) const {
        double noise = 0.0;
        for (std::size_t pixel = 0; pixel < pixels_.size(); ++pixel) {
            const double more = variance_gain != 0.0 ? variance_gain * variance_of_(pixels_[pixel], light) : 0.0;
            noise += std::sqrt(std::max(0.0, variances_[pixel] + more));
        }
        return noise * std::sqrt(cost_ + more_cost);
    }

    std::span<const PixelVariances> pixels_;
    VarianceOf variance_of_;
    double cost_;
    std::vector<double> variances_; ///< Per pixel.
    double now_ = 0.0;
};
} // namespace

std::vector<std::uint32_t> best_ray_counts(std::span<const PixelVariances> pixels, const RayCosts& costs) {
    std::vector<std::uint32_t> counts(costs.of_light.size(), 1);
    NoiseInTime noise(pixels, costs, counts,
                      [](const PixelVariances& pixel, std::size_t light) { return pixel.of_light[light]; });
    for (bool is_better = true; is_better;) {
        is_better = false;
        for (std::size_t light = 0; light < counts.size(); ++light) {
            const double least_saving = costs.least_savings.empty() ? 0.0 : costs.least_savings[light];
            if (counts[light] == most_rays ||
                !noise.take_if(light, -0.5 / counts[light], counts[light] * costs.of_light[light], 1.0 - least_saving))
                continue;
            counts[light] *= 2;
            is_better = true;
        }
    }
    return counts;
}

std::vector<std::uint32_t> best_turns(std::span<const PixelVariances> pixels, const RayCosts& costs,
                                      std::span<const std::uint32_t> counts, std::uint32_t longest) {
    std::vector<std::uint32_t> turns(counts.size(), 1);
    if (longest == 1)
        return turns;
    NoiseInTime noise(pixels, costs, counts, [](const PixelVariances& pixel, std::size_t light) {
        return pixel.of_light[light] + (pixel.of_camera_by_light.empty() ? 0.0 : pixel.of_camera_by_light[light]);
    });
    const double noise_before = noise.now();
    for (bool is_better = true; is_better;) {
        is_better = false;
        for (std::size_t light = 0; light < counts.size(); ++light) {
            if (counts[light] > 1 || 2 * turns[light] > longest ||
                !noise.take_if(light, turns[light], -0.5 * costs.of_light[light] / turns[light], 1.0))
                continue;
            turns[light] *= 2;
            is_better = true;
        }
    }
    if (noise.now() > (1.0 - least_saving_of_turns) * noise_before)
        std::ranges::fill(turns, 1u);
    return turns;
}
} // namespace tyndall::render
