// SPDX-License-Identifier: GPL-3.0-or-later
// How much of the light microfacets send back once, and how much of a Fresnel rise that has: tables, made at first use.
// Based on: Kulla and Conty, Revisiting Physically Based Shading at Imageworks, SIGGRAPH 2017 course notes.
// Bound:    60 ms once; 8 or 16 reads each.
#pragma once

namespace tyndall::ggx {
/// Of white facets with alpha = roughness^2, correlated masking: albedo seen from the cosine.
[[nodiscard]] float albedo(float roughness, float cosine);
/// Its mean over the hemisphere by the cosine.
[[nodiscard]] float mean_albedo(float roughness);
/// Mean of fresnel_rise_of_any_index over the facets that are seen and lit.
[[nodiscard]] float mean_rise(float roughness, float cosine, float ior);
} // namespace tyndall::ggx
