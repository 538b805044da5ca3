// SPDX-License-Identifier: GPL-3.0-or-later
// Microfacets with Trowbridge's and Reitz's distribution, which Walter named GGX. Directions are given around +Z.
// Based on: Walter, Marschner, Li, Torrance, Microfacet Models for Refraction through Rough Surfaces, EGSR 2007 (eq. 20,
//           33, 34); Heitz, Understanding the Masking-Shadowing Function, JCGT 3(2), 2014 (eq. 72, 99); Heitz, Sampling
//           the GGX Distribution of Visible Normals, JCGT 7(4), 2018 (section 3, listing 1).
// Differs:  the distribution takes the sine of the facet's angle, too: next to the normal, 1 - cos^2 has no digits left.
#pragma once
#include "core/math.hpp"
#include "core/sampling.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tyndall::ggx {
/// Eq. 33 of Walter: of facets whose normal has this squared sine and cosine against the surface's.
[[nodiscard]] inline float distribution(float alpha, float sine2, float cosine2) {
    const float alpha2 = alpha * alpha, spread = sine2 + alpha2 * cosine2;
    return alpha2 / (std::numbers::pi_v<float> * spread * spread);
}
/// Lambda, eq. 72 of Heitz 2014; the cosine is positive.
[[nodiscard]] inline float lambda(float alpha, float cosine) {
    const float tangent2 = std::max(0.0f, 1.0f / (cosine * cosine) - 1.0f);
    return 0.5f * (std::sqrt(1.0f + alpha * alpha * tangent2) - 1.0f);
}
/// Share of facets that a direction sees.
[[nodiscard]] inline float masking(float alpha, float cosine) { return 1.0f / (1.0f + lambda(alpha, cosine)); }
/// Share that both see: eq. 99 of Heitz 2014, or, separable, eq. 23 of Walter.
[[nodiscard]] inline float masking_and_shadowing(float alpha, float cosine_a, float cosine_b, bool is_separable) {
    if (is_separable)
        return masking(alpha, cosine_a) * masking(alpha, cosine_b);
    return 1.0f / (1.0f + lambda(alpha, cosine_a) + lambda(alpha, cosine_b));
}
/// Of width `alpha` along x and y, the normal that a point of the unit disc stands for: of points spread evenly, as
/// often as the direction sees it.
[[nodiscard]] inline vec3 visible_normal(const vec3& outgoing, vec2 alpha, vec2 disc) {
    const vec3 stretched = glm::normalize(vec3(alpha.x * outgoing.x, alpha.y * outgoing.y, outgoing.z));
    const float across2 = stretched.x * stretched.x + stretched.y * stretched.y;
    const vec3 first = across2 > 1e-14f ? vec3(-stretched.y, stretched.x, 0.0f) / std::sqrt(across2) : vec3(1, 0, 0);
    const vec3 second = glm::cross(stretched, first);
    const float upper = 0.5f * (1.0f + stretched.z);
    disc.y = (1.0f - upper) * std::sqrt(std::max(0.0f, 1.0f - disc.x * disc.x)) + upper * disc.y;
    const float height = std::sqrt(std::max(0.0f, 1.0f - glm::dot(disc, disc)));
    const vec3 normal = disc.x * first + disc.y * second + height * stretched;
    return glm::normalize(vec3(alpha.x * normal.x, alpha.y * normal.y, std::max(1e-6f, normal.z)));
}
[[nodiscard]] inline vec3 sample_visible_normal(const vec3& outgoing, vec2 alpha, vec2 u) {
    return visible_normal(outgoing, alpha, sample_concentric_disc(u));
}
/// Of the direction that is mirrored by such a facet.
[[nodiscard]] inline float reflected_pdf_per_sr(float alpha, float cosine_outgoing, float sine2, float cosine2) {
    return distribution(alpha, sine2, cosine2) * masking(alpha, cosine_outgoing) / (4.0f * cosine_outgoing);
}
} // namespace tyndall::ggx
