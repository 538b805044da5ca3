// SPDX-License-Identifier: GPL-3.0-or-later
// Sheen of fibres that stand on a surface, as Blender has it from 4.0 on.
// Based on: Zeltner, Burley, Chiang, Practical Multiple-Scattering Sheen Using Linearly Transformed Cosines, SIGGRAPH Talks
//           2022: of a cosine and a roughness three numbers, a, b and an albedo R. Where x is along the view's part in the
//           surface and z the normal, R cos / pi is that of a direction w whose (a x + b z, a y, z) it is around.
// Differs:  the table is not the authors': it was measured (tests/support/measure_sheen.py).
// Bound:    12 reads a point; 15 operations a direction. The table: 12 KiB.
#pragma once
#include "core/math.hpp"
#include "core/sampling.hpp"
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace tyndall::sheen {
inline constexpr std::size_t node_count = 32;
/// By roughness and cosine, both even steps from 0 to 1: a, b and R, of which 100,000 are 1.
extern const std::int32_t table[node_count][node_count][3];
inline constexpr float least_roughness = 1e-3f;

struct Shape {
    float a, b, albedo;
};
/// Clamps both. Seen from below the surface it is as from along it.
[[nodiscard]] Shape shape(float roughness, float view_cosine);

/// Others vary so little over a lamp that to aim at it is as good as can be: by the cosine, the mean square of what they
/// reflect is up to three times the square of the mean; of narrow ones up to a thousand.
[[nodiscard]] inline bool is_narrow(float a) { return a < 0.3f; }

/// Of an albedo of 1, 1/sr, from cosines of normal, view and light, of which only the light's is above 0.
[[nodiscard]] inline float per_irradiance(float a, float b, float light_cosine, float view_cosine,
                                          float between_cosine) {
    const float view_sine2 = std::max(1.0f - view_cosine * view_cosine, 1e-12f);
    const float light_sine2 = std::max(1.0f - light_cosine * light_cosine, 0.0f);
    const float along = (between_cosine - light_cosine * view_cosine) / std::sqrt(view_sine2);
    const float across2 = std::max(light_sine2 - along * along, 0.0f);
    const float x = a * along + b * light_cosine;
    const float ratio = a / (x * x + a * a * across2 + light_cosine * light_cosine);
    return std::numbers::inv_pi_v<float> * ratio * ratio;
}
/// A unit direction as often as light is reflected there, above the surface; axes as above.
[[nodiscard]] inline vec3 sample(float a, float b, vec2 u) {
    const vec3 even = sample_cosine_hemisphere(u);
    return glm::normalize(vec3((even.x - b * even.z) / a, even.y / a, even.z));
}
/// No direction is denser.
[[nodiscard]] inline float most_pdf_per_sr(float a, float b) {
    const float widest = (1.0f + std::abs(b)) / a; // of a unit direction that is transformed back
    return std::numbers::inv_pi_v<float> * a * a * std::pow(widest * widest + 1.0f, 1.5f);
}
} // namespace tyndall::sheen
