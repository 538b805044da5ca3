// SPDX-License-Identifier: GPL-3.0-or-later
// Lobes that are broad, per irradiance, 1/sr: cosines against the surface's normal of light and of view.
// Based on: Oren and Nayar, Generalization of Lambert's Reflectance Model, SIGGRAPH 1994, in Fujii's form (A Tiny
//           Improvement of Oren-Nayar Reflectance Model, 2013, with its G), and what scatters on between facets as in
//           OpenPBR 1.0's energy-preserving form; Burley, Physically Based Shading at Disney, SIGGRAPH 2012 course notes,
//           5.3 and 5.9, in the terms of Burley 2015, eq. 4; Ashikhmin, Distribution-based BRDFs, 2007 (velvet).
#pragma once
#include "core/math.hpp"
#include "core/sampling.hpp"
#include <algorithm>
#include <cfloat>
#include <cmath>
#include <numbers>

namespace tyndall {
namespace oren_nayar {
struct Coefficients {
    float a, b;
};
/// Fujii's, up to Blender 3.x: A + B pi is not its albedo, which exceeds 1 nowhere.
[[nodiscard]] inline Coefficients coefficients_of_blender3(float roughness) {
    const float a = 1.0f / (pi + (3.0f * pi - 4.0f) / 6.0f * roughness);
    return {a, roughness * a};
}
/// Those of which energy_preserving_part knows the albedo.
[[nodiscard]] inline Coefficients coefficients(float roughness) {
    const float a = 1.0f / (pi + roughness * (0.5f * pi - 2.0f / 3.0f));
    return {a, roughness * a};
}
/// Integral of s / t over the light's hemisphere.
[[nodiscard]] inline float g(float cosine) {
    if (cosine < 1e-6f)
        return 0.5f * std::numbers::pi_v<float> - 2.0f / 3.0f - cosine;
    const float sine = std::sqrt(std::max(0.0f, 1.0f - cosine * cosine)), angle = std::acos(std::min(cosine, 1.0f));
    return sine * (angle - 2.0f / 3.0f - sine * cosine) + 2.0f / 3.0f * (sine / cosine) * (1.0f - sine * sine * sine);
}
[[nodiscard]] inline float once(const Coefficients& of, float light_cosine, float view_cosine, float between_cosine) {
    float t = between_cosine - light_cosine * view_cosine;
    if (t > 0.0f)
        t /= std::max(light_cosine, view_cosine) + FLT_MIN;
    return of.a + of.b * t;
}
/// Share that is sent back at once.
[[nodiscard]] inline float once_albedo(const Coefficients& of, float cosine) {
    return of.a * std::numbers::pi_v<float> + of.b * g(cosine);
}
/// Of what is not, but for the light's own share, 1 - once_albedo of its cosine.
[[nodiscard]] inline Rgb further(const Coefficients& of, const Rgb& albedo, float view_cosine) {
    const float mean = of.a * pi + (2.0f * pi - 5.6f) / 3.0f * of.b;
    return albedo * albedo * (mean / (1.0f - mean)) / (1.0f - albedo * (1.0f - mean)) *
           ((1.0f - once_albedo(of, view_cosine)) / pi);
}
} // namespace oren_nayar

namespace burley {
[[nodiscard]] inline float schlick(float cosine) {
    const float rest = std::clamp(1.0f - cosine, 0.0f, 1.0f);
    return rest * rest * rest * rest * rest;
}
/// What of it comes back the way it came.
[[nodiscard]] inline float retro(float roughness, float light_cosine, float view_cosine, float between_cosine) {
    const float light = schlick(light_cosine), view = schlick(view_cosine);
    const float retro = roughness * (between_cosine + 1.0f); // 2 roughness cos^2 of half the angle between
    return std::numbers::inv_pi_v<float> * retro * (light + view + light * view * (retro - 1.0f));
}
[[nodiscard]] inline float diffuse(float roughness, float light_cosine, float view_cosine, float between_cosine) {
    return std::numbers::inv_pi_v<float> * (1.0f - 0.5f * schlick(light_cosine)) *
               (1.0f - 0.5f * schlick(view_cosine)) +
           retro(roughness, light_cosine, view_cosine, between_cosine);
}
[[nodiscard]] inline float sheen(float half_cosine) { return schlick(half_cosine); }
} // namespace burley

/// `inverse_variance`: 1 / sigma^2; `normal_half`: of normal and half vector; `view_half`: of view and half vector.
[[nodiscard]] inline float velvet(float inverse_variance, float light_cosine, float view_cosine, float normal_half,
                                  float view_half) {
    if (normal_half >= 1.0f - 1e-5f || view_half <= 1e-5f)
        return 0.0f;
    const float ratio = 2.0f * std::max(normal_half / view_half, 1e-5f);
    const float sine2 = 1.0f - normal_half * normal_half, cotangent2 = normal_half * normal_half / sine2;
    const float distribution =
        std::exp(-cotangent2 * inverse_variance) * inverse_variance * std::numbers::inv_pi_v<float> / (sine2 * sine2);
    const float shadowing = std::min(1.0f, ratio * std::min(view_cosine, light_cosine));
    return 0.25f * distribution * shadowing / (view_cosine * light_cosine);
}

namespace toon {
/// Of a cone of even light that fades at its edge, 1 - cos of the half angle.
[[nodiscard]] inline float one_minus_cos_half_angle(float full_angle, float fading_angle) {
    return one_minus_cos(std::min(full_angle + fading_angle, 0.5f * std::numbers::pi_v<float>));
}
/// Radiance per radiance and solid angle of that cone, with the light's cosine; of its middle, the density of directions that
/// are drawn within it.
[[nodiscard]] inline float reflected(float full_angle, float fading_angle, float cosine) {
    const float angle = std::acos(std::clamp(cosine, 0.0f, 1.0f));
    const float share = angle < full_angle                  ? 1.0f
                        : angle < full_angle + fading_angle ? 1.0f - (angle - full_angle) / fading_angle
                                                            : 0.0f;
    return share > 0.0f ? share * uniform_cone_pdf_per_sr(one_minus_cos_half_angle(full_angle, fading_angle)) : 0.0f;
}
[[nodiscard]] inline float pdf_per_sr(float full_angle, float fading_angle, float cosine) {
    const float one_minus_cos = one_minus_cos_half_angle(full_angle, fading_angle);
    return 1.0f - cosine < one_minus_cos ? uniform_cone_pdf_per_sr(one_minus_cos) : 0.0f;
}
} // namespace toon
} // namespace tyndall
