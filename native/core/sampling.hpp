// SPDX-License-Identifier: GPL-3.0-or-later
// Maps from the unit square to the shapes that rendering integrates over. Each says its PDF, and each is continuous in
// u but for a seam, so that strata of the square stay strata of the shape.
#pragma once
#include "core/math.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tyndall {
/// Uniform on the unit disc; PDF 1 / pi.
/// Based on: Shirley and Chiu, A Low Distortion Map Between Disk and Square, JGT 2(3), 1997.
[[nodiscard]] inline vec2 sample_concentric_disc(vec2 u) {
    const vec2 square = 2.0f * u - 1.0f;
    if (square == vec2(0.0f))
        return vec2(0.0f);
    constexpr float quarter_pi = 0.25f * std::numbers::pi_v<float>;
    if (std::abs(square.x) > std::abs(square.y)) {
        const float angle = quarter_pi * (square.y / square.x);
        return square.x * vec2(std::cos(angle), std::sin(angle));
    }
    const float angle = quarter_pi * (square.x / square.y);
    return square.y * vec2(std::sin(angle), std::cos(angle));
}

/// Around +Z with PDF cos / pi per steradian.
[[nodiscard]] inline vec3 sample_cosine_hemisphere(vec2 u) {
    const vec2 disc = sample_concentric_disc(u);
    return {disc, std::sqrt(std::max(0.0f, 1.0f - glm::dot(disc, disc)))};
}
[[nodiscard]] inline float cosine_hemisphere_pdf_per_sr(float cosine) {
    return std::max(0.0f, cosine) * std::numbers::inv_pi_v<float>;
}

/// Uniform in the cone around +Z, given as 1 - cos of its half angle, (0, 2].
/// Takes 1 - cos, not cos: the sun's is 1e-5, of which float's cosine keeps two digits.
[[nodiscard]] inline vec3 sample_uniform_cone(vec2 u, float one_minus_cos_half_angle) {
    const vec2 disc = sample_concentric_disc(u);
    const float one_minus_cos = std::min(1.0f, glm::dot(disc, disc)) * one_minus_cos_half_angle;
    return {std::sqrt(one_minus_cos_half_angle * (2.0f - one_minus_cos)) * disc, 1.0f - one_minus_cos};
}
[[nodiscard]] inline float uniform_cone_pdf_per_sr(float one_minus_cos_half_angle) {
    return 0.5f * std::numbers::inv_pi_v<float> / one_minus_cos_half_angle;
}
/// 1 - cos without cancellation.
[[nodiscard]] inline float one_minus_cos(float angle_rad) {
    const float sine = std::sin(0.5f * angle_rad);
    return 2.0f * sine * sine;
}

/// Uniform on the unit sphere; PDF 1 / (4 pi) per steradian.
[[nodiscard]] inline vec3 sample_uniform_sphere(vec2 u) { return sample_uniform_cone(u, 2.0f); }

/// A direction given around +Z, turned to be around the unit vector `axis`.
[[nodiscard]] inline vec3 from_frame(const vec3& axis, const vec3& local) {
    const auto [tangent, bitangent] = orthonormal_basis(axis);
    return local.x * tangent + local.y * bitangent + local.z * axis;
}

/// Of those at this cosine to an axis, by a turn in [0, 1).
[[nodiscard]] inline vec3 direction_around(const vec3& axis, float cosine, float turn) {
    const float sine = std::sqrt(std::max(0.0f, 1.0f - cosine * cosine)),
                turn_rad = 2.0f * std::numbers::pi_v<float> * turn;
    return from_frame(axis, {sine * std::cos(turn_rad), sine * std::sin(turn_rad), cosine});
}

/// What is left of a number in [0, 1) that chose the part [first, first + width): even again within it.
[[nodiscard]] inline float even_within(float u, float first, float width) {
    return std::min((u - first) / width, 0x1.fffffep-1f);
}

/// Power heuristic with exponent 2 (Veach 1997, section 9.2): share of the strategy with density `own`.
/// One of both is not 0.
[[nodiscard]] inline float power_share(float own, float other) {
    const float ratio = other / own; // either may be larger than what has a square
    return 1.0f / (1.0f + ratio * ratio);
}
} // namespace tyndall
