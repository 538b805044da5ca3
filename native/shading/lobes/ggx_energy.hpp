// SPDX-License-Identifier: GPL-3.0-or-later
// How much of the light microfacets send back once, and how much of a Fresnel rise that has: tables, made at first use.
// Based on: Kulla and Conty, Revisiting Physically Based Shading at Imageworks, SIGGRAPH 2017 course notes.
// Bound:    70 ms once, 13 for each index of glass that is rough; 6 to 12 reads each.
#pragma once

namespace tyndall::ggx {
/// What comes back seen from a cosine, and its mean over the hemisphere by the cosine.
struct Albedo {
    float seen, mean;
};
/// Of white facets with alpha = roughness^2, correlated masking.
[[nodiscard]] Albedo albedo(float roughness, float cosine);
/// Of such facets of clear glass, on both sides; `ior`: relative, below 1 from within.
[[nodiscard]] Albedo glass_albedo(float roughness, float cosine, float ior);
/// Mean of fresnel_rise_of_any_index over the facets that are seen and lit.
[[nodiscard]] float mean_rise(float roughness, float cosine, float ior);
} // namespace tyndall::ggx
