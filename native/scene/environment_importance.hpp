// SPDX-License-Identifier: GPL-3.0-or-later
// Directions drawn as often as an equirectangular image is bright there.
// Based on: Pharr, Jakob, Humphreys, Physically Based Rendering, 4th ed. 2023, section 12.5.
// Differs:  the PDF is constant per cell but covers the bilinear footprint: a texel weighs what the interpolated image
//           holds within its square, so that no radiance lies where the PDF is 0; 1 % of all samples are uniform.
//           A cell is a square of texels, as wide as the whole image is even, and wider yet along rows that are: a
//           smooth sky needs tables that stay in a cache, where those of its texels are missed twice a sample, and a
//           small sun needs narrow cells in its own rows alone.
// Bound:    4 bytes per cell, and while they are found 8 per square of four texels; a sample is two binary searches and
//           two roots, a PDF three reads.
#pragma once
#include "core/math.hpp"
#include "core/piecewise_constant.hpp"
#include <vector>

namespace tyndall {
struct EnvironmentImage; // world.hpp

class EnvironmentImportance {
public:
    explicit EnvironmentImportance(const EnvironmentImage& image);

    struct Sample {
        vec2 uv;       ///< In the image, [0, 1]^2.
        double height; ///< Of the direction in the image's space: its z.
        float pdf_per_sr;
    };
    [[nodiscard]] Sample sample(vec2 u) const;
    [[nodiscard]] float pdf_per_sr(vec2 uv) const;
    [[nodiscard]] std::uint32_t columns(std::uint32_t row) const { return cells_.columns(row); }
    [[nodiscard]] std::uint32_t rows() const { return cells_.rows(); }

private:
    PiecewiseConstant2d cells_;
    std::vector<double> edge_heights_; ///< rows + 1.
    std::vector<float> per_sr_;        ///< Of a cell in each row.
};
/// Angle of (x, y) to +X, [-pi, pi], to 3e-7.
[[nodiscard]] float angle_of(float y, float x);
} // namespace tyndall
