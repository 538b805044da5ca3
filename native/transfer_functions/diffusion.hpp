// SPDX-License-Identifier: GPL-3.0-or-later
// Colours that spread smoothly from a few places over a picture.
#pragma once
#include "core/progress.hpp"
#include "transfer_functions/transfer_function.hpp"
#include <span>
#include <vector>

namespace tyndall::transfer_functions {
/// Over [0, 1]^2, the u that bends least: of those that have the constraints' values at their positions, u has the
/// smallest integral of |grad u|^2 + smoothness^2 (laplacian u)^2, and flat borders. Colours spread multiplied with
/// alpha, so that a transparent constraint takes colour away and gives none.
class Diffusion {
public:
    /// Of at least one constraint, for a picture with size^2 texels. Throws Cancelled.
    Diffusion(std::span<const Constraint> constraints, float smoothness, std::uint32_t size, const Progress& progress);
    /// Colours with alpha at a row's texels, within the range of the constraints'; alpha is not multiplied in.
    void row(std::uint32_t row, std::span<vec4> colours) const;

private:
    std::uint32_t size_;
    std::size_t stride_;                ///< Of a row of texels.
    std::vector<float> cosines_;        ///< Per cosine, and texel along an axis.
    std::vector<float> amplitudes_;     ///< Per row of texels, channel, and cosine along x; multiplied with alpha.
    vec4 lowest_{0.0f}, highest_{0.0f}; ///< Of the constraints, alpha not multiplied in.
};
} // namespace tyndall::transfer_functions
