// SPDX-License-Identifier: GPL-3.0-or-later
// Pixel reconstruction by filter importance sampling: a sample's place is drawn from the filter, so that all samples
// weigh the same and no sample is shared between pixels.
// Based on: Ernst, Stamminger, Greiner, Filter Importance Sampling, IEEE Symposium on Interactive Ray Tracing 2006;
//           shapes and widths as Cycles defines them, so that the same settings give the same picture.
#pragma once
#include "core/math.hpp"
#include <cstdint>
#include <vector>

namespace tyndall::render {
enum class PixelFilter : std::uint8_t { Box = 0, Gaussian = 1, BlackmanHarris = 2 };

/// A separable filter on [-radius_px, radius_px] in x and y.
class FilterSampler {
public:
    /// Radius: width / 2 (box), 1.5 width (Gaussian, exp(-8 (x / width)^2)), width (Blackman-Harris). Throws
    /// InvalidInput for a width outside [0.01, 10], Blender's range.
    FilterSampler(PixelFilter filter, float width_px);

    /// Offset from the pixel's centre whose density is the filter; u in [0, 1)^2. u = 0.5 gives 0.
    [[nodiscard]] vec2 offset_px(vec2 u) const { return {offset_px(u.x), offset_px(u.y)}; }
    [[nodiscard]] float radius_px() const { return radius_px_; }
    /// Density of an offset in one direction, 1/px; integrates to 1.
    [[nodiscard]] float density_per_px(float offset_px) const;

private:
    [[nodiscard]] float offset_px(float u) const;
    [[nodiscard]] float shape(float offset_px) const;

    PixelFilter filter_;
    float width_px_, radius_px_;
    float integral_px_ = 1.0f;
    std::vector<float> half_cdf_;           ///< Of offsets in [0, radius], at equal steps; empty for a box.
    std::vector<std::uint16_t> first_step_; ///< Where the search begins, by the CDF's value in as many equal slots.
};
} // namespace tyndall::render
