// SPDX-License-Identifier: GPL-3.0-or-later
// Microfacets whose slopes are distributed normally, as Beckmann and Spizzichino have them. Directions are given around +Z.
// Based on: Walter, Marschner, Li, Torrance, Microfacet Models for Refraction through Rough Surfaces, EGSR 2007 (eq. 25);
//           Heitz, Understanding the Masking-Shadowing Function, JCGT 3(2), 2014 (section 5.2, and 5.4 for two widths);
//           Heitz and d'Eon, Importance Sampling Microfacet-Based BSDFs using the Distribution of Visible Normals, EGSR
//           2014; Jakob, An Improved Visible Normal Sampling Routine for the Beckmann Distribution, 2014; Giles,
//           Approximating the erfinv Function, GPU Computing Gems 2, 2011 (its table for floats).
// Differs:  Lambda is exact, so that densities add up to 1; Cycles' is Walter's rational fit of it, by which its masking is
//           up to 0.35 % off. Newton's steps are bracketed, and go on until a float's digits are used up.
// Bound:    twice the time of ggx.hpp a direction, three times to draw one.
#pragma once
#include "core/math.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tyndall::beckmann {
/// Of facets whose normal has this squared cosine, and this sum of squared sines along both axes over the widths there,
/// squared; `alpha2` is the product of the widths.
[[nodiscard]] inline float distribution(float alpha2, float stretched2, float cosine2) {
    cosine2 = std::max(cosine2, 1e-12f);
    return std::exp(-stretched2 / cosine2) / (pi * alpha2 * cosine2 * cosine2);
}
/// Of a direction's squared tangent, times the squared width along it.
[[nodiscard]] inline float lambda(float slope2) {
    if (!(slope2 > 0.08f)) // it is below 2e-8, which 1 + lambda does not show
        return 0.0f;
    const float a = 1.0f / std::sqrt(slope2);
    return 0.5f * std::max(0.0f, std::numbers::inv_sqrtpi_v<float> * std::exp(-a * a) / a - std::erfc(a));
}
/// x with erf(x) = y, to 4e-7 of it; beyond what floats tell from 1, as if it was there.
[[nodiscard]] inline float inverse_erf(float y) {
    constexpr float inner[] = {1.50140941f,     0.246640727f,   -0.00417768164f, -0.00125372503f, 0.00021858087f,
                               -4.39150654e-6f, -3.5233877e-6f, 3.43273939e-7f,  2.81022636e-8f};
    constexpr float outer[] = {2.83297682f,     1.00167406f,    0.00943887047f,  -0.0076224613f,  0.00573950773f,
                               -0.00367342844f, 0.00134934322f, 0.000100950558f, -0.000200214257f};
    y = std::clamp(y, -0.99999994f, 0.99999994f);
    const float w = -std::log((1.0f - y) * (1.0f + y));
    const bool is_inner = w < 5.0f;
    const float x = is_inner ? w - 2.5f : std::sqrt(w) - 3.0f;
    const auto& table = is_inner ? inner : outer;
    float sum = table[8];
    for (int i = 7; i >= 0; --i)
        sum = sum * x + table[i];
    return sum * y;
}
/// Slope along x of facets of width 1, as often as a direction with this cosine, (0, 1], in the plane of x and z sees it;
/// u in [0, 1).
[[nodiscard]] inline float sample_visible_slope(float cosine, float u) {
    const float tangent = std::sqrt(std::max(0.0f, 1.0f - cosine * cosine)) / cosine;
    const float share = std::numbers::inv_sqrtpi_v<float> * tangent;
    // With b the error function of the slope, what is seen of all that is less steep grows as 1 + b + share exp(-slope^2),
    // up to where facets are seen from their edge.
    const float edge = 1.0f / std::max(tangent, 1e-6f);
    float low = -1.0f, high = std::erf(edge);
    const float wanted = u * (1.0f + high + share * std::exp(-edge * edge));
    // exp(-slope^2) is about 1 - b^2.
    float b = share > 1e-3f ? (0.5f - std::sqrt(share * (share - wanted + 1.0f) + 0.25f)) / share : wanted - 1.0f;
    float slope = 0.0f;
    for (int step = 0; step < 12; ++step) {
        b = b > low && b < high ? b : 0.5f * (low + high);
        slope = inverse_erf(b);
        const float beyond = 1.0f + b + share * std::exp(-slope * slope) - wanted;
        if (std::abs(beyond) <= 1e-6f * (1.0f + wanted))
            break;
        (beyond > 0.0f ? high : low) = b;
        b -= beyond / (1.0f - slope * tangent);
    }
    return slope;
}
/// Of width `alpha` along x and y.
[[nodiscard]] inline vec3 sample_visible_normal(const vec3& outgoing, vec2 alpha, vec2 u) {
    const vec3 stretched = glm::normalize(vec3(alpha.x * outgoing.x, alpha.y * outgoing.y, outgoing.z));
    const float sine = std::sqrt(stretched.x * stretched.x + stretched.y * stretched.y);
    const vec2 around = sine > 1e-7f ? vec2(stretched.x, stretched.y) / sine : vec2(1, 0);
    const float along = sample_visible_slope(std::clamp(stretched.z, 1e-4f, 1.0f), u.x);
    const float across = inverse_erf(2.0f * u.y - 1.0f);
    return glm::normalize(vec3(-alpha.x * (around.x * along - around.y * across),
                               -alpha.y * (around.y * along + around.x * across), 1.0f));
}
} // namespace tyndall::beckmann
