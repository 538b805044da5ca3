// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/pixel_filter.hpp"
#include "core/errors.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall::render {
// The inverse is linear between steps: 1024 of them place a sample to 1e-6 of the radius where the filter matters.
static constexpr std::size_t step_count = 1024;

FilterSampler::FilterSampler(PixelFilter filter, float width_px) : filter_(filter), width_px_(width_px) {
    require_in(width_px, 0.01f, 10.0f, "filter_width_px");
    switch (filter) {
    case PixelFilter::Box:
        radius_px_ = 0.5f * width_px;
        integral_px_ = width_px;
        return;
    case PixelFilter::Gaussian:
        radius_px_ = 1.5f * width_px;
        break;
    case PixelFilter::BlackmanHarris:
        radius_px_ = width_px;
        break;
    }
    half_cdf_.resize(step_count + 1);
    double sum = 0.0;
    for (std::size_t step = 0; step < step_count; ++step) {
        sum += shape((static_cast<float>(step) + 0.5f) * radius_px_ / step_count);
        half_cdf_[step + 1] = static_cast<float>(sum);
    }
    for (float& value : half_cdf_)
        value /= static_cast<float>(sum);
    integral_px_ = static_cast<float>(2.0 * sum * radius_px_ / step_count);
    std::size_t step = 0;
    for (std::size_t slot = 0; slot < step_count; ++slot) {
        while (step + 1 < step_count && half_cdf_[step + 1] <= static_cast<float>(slot) / step_count)
            ++step;
        first_step_.push_back(static_cast<std::uint16_t>(step));
    }
}

float FilterSampler::shape(float offset_px) const {
    switch (filter_) {
    case PixelFilter::Box:
        return 1.0f;
    case PixelFilter::Gaussian:
        return std::exp(-8.0f * offset_px * offset_px / (width_px_ * width_px_));
    case PixelFilter::BlackmanHarris: { // Harris 1978, four terms, from one end of the window to the other
        const float x = pi * (offset_px / radius_px_ + 1.0f);
        return 0.35875f - 0.48829f * std::cos(x) + 0.14128f * std::cos(2.0f * x) - 0.01168f * std::cos(3.0f * x);
    }
    }
    return 0.0f;
}

float FilterSampler::density_per_px(float offset_px) const {
    return std::abs(offset_px) > radius_px_ ? 0.0f : shape(offset_px) / integral_px_;
}

float FilterSampler::offset_px(float u) const {
    const float centred = 2.0f * u - 1.0f; // the filter is even: sign and size
    if (half_cdf_.empty())
        return centred * radius_px_;
    const float target = std::abs(centred);
    std::size_t step = first_step_[std::min(static_cast<std::size_t>(target * step_count), step_count - 1)];
    while (step + 1 < step_count && half_cdf_[step + 1] <= target)
        ++step;
    const float before = half_cdf_[step], after = half_cdf_[step + 1];
    const float within = after > before ? (target - before) / (after - before) : 0.0f;
    return std::copysign((static_cast<float>(step) + within) * radius_px_ / step_count, centred);
}
} // namespace tyndall::render
