// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/texture_steps.hpp"
#include "light_shafts/lit_pieces.hpp"
#include <cmath>

namespace tyndall::light_shafts {
float mean_place(float depth) {
    const double x = depth;
    if (std::abs(x) < 0.1) // fifth order: 3e-10 at the seam
        return static_cast<float>(0.5 - x * (1.0 / 12.0 - x * x / 720.0));
    return static_cast<float>(1.0 / x - 1.0 / std::expm1(x));
}

/// Weights of equal steps are powers of one ratio: shares of what the whole part scatters. Counted from the end that loses
/// less, so that none of them overflows.
static void weigh(const ScatterPiece& piece, float near_m, float far_m, const Rgb& transmittance,
                  std::span<TextureStep> steps) {
    const Rgb whole = transmittance * scattered(piece, near_m, far_m);
    const auto count = static_cast<double>(steps.size());
    const double step_m = (double{far_m} - double{near_m}) / count;
    for (int channel = 0; channel < 3; ++channel) {
        const bool falls = piece.depth_per_m[channel] < 0.0f;
        const double depth = std::abs(piece.depth_per_m[channel]) * step_m, ratio = std::exp(-depth);
        double weight = whole[channel] * (depth > 0.0 ? std::expm1(-depth) / std::expm1(-depth * count) : 1.0 / count);
        for (std::size_t index = 0; index < steps.size(); ++index, weight *= ratio)
            steps[falls ? steps.size() - 1 - index : index].weight[channel] = static_cast<float>(weight);
    }
}

void append_texture_steps(const ViewRay& ray, std::span<const ScatterPiece> pieces, std::span<const LitInterval> lit,
                          const PlanarPlacement& placement, float step_m, std::vector<TextureStep>& steps) {
    const vec2 uv_at_camera = placement.uv(ray.origin), uv_per_m = placement.uv_per_m(ray.direction);
    for_each_lit_part(pieces, lit, [&](const ScatterPiece& piece, float near_m, float far_m, const Rgb& transmittance) {
        const auto count = std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil((far_m - near_m) / step_m)));
        const float own_step_m = (far_m - near_m) / static_cast<float>(count);
        const float node_m = near_m + own_step_m * mean_place(average(piece.depth_per_m) * own_step_m);
        const std::size_t begin = steps.size();
        steps.resize(begin + count);
        const std::span own(steps.data() + begin, count);
        weigh(piece, near_m, far_m, transmittance, own);
        for (std::size_t index = 0; index < count; ++index)
            own[index].uv = uv_at_camera + (node_m + static_cast<float>(index) * own_step_m) * uv_per_m;
    });
}
} // namespace tyndall::light_shafts
