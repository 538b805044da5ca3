// SPDX-License-Identifier: GPL-3.0-or-later
// The clear coat of Blender's principled shader up to 3.x: a distribution with a longer tail than ggx.hpp's.
// Based on: Burley, Physically Based Shading at Disney, SIGGRAPH 2012 course notes, appendix B.1 and B.2: GTR with
//           gamma = 1 (eq. 4), its samples (eq. 5).
#pragma once
#include "core/math.hpp"
#include <cmath>
#include <numbers>

namespace tyndall::clearcoat {
/// What masks and shadows facets does not follow their distribution: always so wide.
inline constexpr float masking_alpha = 0.25f;

[[nodiscard]] inline float distribution(float alpha, float cosine2) {
    const float alpha2 = alpha * alpha;
    if (alpha2 >= 1.0f)
        return std::numbers::inv_pi_v<float>;
    return (alpha2 - 1.0f) / (std::numbers::pi_v<float> * std::log(alpha2) * (1.0f + (alpha2 - 1.0f) * cosine2));
}
/// Around +Z, with PDF distribution * cosine.
[[nodiscard]] inline vec3 sample_normal(float alpha, vec2 u) {
    const float alpha2 = alpha * alpha;
    const float cosine2 = alpha2 >= 1.0f ? 1.0f - u.x : (1.0f - std::pow(alpha2, 1.0f - u.x)) / (1.0f - alpha2);
    const float sine = std::sqrt(std::max(0.0f, 1.0f - cosine2)), angle = 2.0f * std::numbers::pi_v<float> * u.y;
    return {sine * std::cos(angle), sine * std::sin(angle), std::sqrt(std::max(0.0f, cosine2))};
}
} // namespace tyndall::clearcoat
