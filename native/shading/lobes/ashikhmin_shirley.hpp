// SPDX-License-Identifier: GPL-3.0-or-later
// Phong's gloss around half vectors, with exponents along and across. Half vectors are given around +Z.
// Based on: Ashikhmin and Shirley, An Anisotropic Phong BRDF Model, JGT 5(2), 2000 (eq. 4, 6, 8 to 10).
// Differs:  the coupled diffuse term and Fresnel's are left out, and exponents come from widths, as in Cycles: of a width
//           alpha, 2 / alpha^2 - 2. A half vector's angle is drawn from the whole circle at once.
//           Powers of cosines are taken by the sine: next to the normal a cosine has no digits left.
//           Cycles mirrors at the wrong side of half vectors that face away from the viewer, which brightens what is
//           seen flat under light from all around: by 40 % at 80 degrees. Here such directions are lost.
// Bound:    twice the time of ggx.hpp a direction, 1.4 times to draw one.
#pragma once
#include "core/math.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tyndall::ashikhmin_shirley {
/// Cycles' floor: along either axis it is no narrower; where it is not wider along both, it is a mirror.
inline constexpr float least_width = 1e-4f;

[[nodiscard]] inline vec2 exponents(vec2 alpha) {
    alpha = glm::max(alpha, vec2(least_width));
    return 2.0f / (alpha * alpha) - 2.0f;
}
/// Of half vectors, 1/sr; `half` is unit, and above the surface. No facet hides another.
[[nodiscard]] inline float density_per_sr(vec2 exponent, const vec3& half) {
    const vec2 sine2(half.x * half.x, half.y * half.y);
    const float all = sine2.x + sine2.y;
    // The logarithm of the squared cosine, per squared sine.
    const float rate = all > 1e-12f ? std::log1p(-std::min(all, 0.9999999f)) / all : -1.0f;
    return std::sqrt((exponent.x + 1.0f) * (exponent.y + 1.0f)) *
           (0.5f * std::numbers::inv_pi_v<float>)*std::exp(0.5f * rate * glm::dot(exponent, sine2));
}
[[nodiscard]] inline vec3 sample_half(vec2 exponent, vec2 u) {
    const float turn = 2.0f * pi * u.x;
    const vec2 around = glm::normalize(
        vec2(std::cos(turn) * std::sqrt(exponent.y + 1.0f), std::sin(turn) * std::sqrt(exponent.x + 1.0f)));
    const float of_cosine = glm::dot(exponent, around * around);
    const float sine2 = -std::expm1(2.0f * std::log1p(-u.y) / (of_cosine + 1.0f));
    return {std::sqrt(sine2) * around, std::sqrt(std::max(0.0f, 1.0f - sine2))};
}
} // namespace tyndall::ashikhmin_shirley
