// SPDX-License-Identifier: GPL-3.0-or-later
// How much more a surface reflects towards grazing angles.
// Based on: Fresnel's equations; Schlick, An Inexpensive BRDF Model for Physically-based Rendering, Eurographics 1994.
// Differs:  what rises between "seen straight" and "grazing" is apart from these two colours, as in Cycles 3's principled
//           shader; its metals from 4.0 on rise by Schlick's fifth power.
#pragma once
#include <algorithm>
#include <cmath>

namespace tyndall {
/// Share that a dielectric of relative index `ior` >= 1 reflects of unpolarised light from outside; cosine in [0, 1].
[[nodiscard]] inline float fresnel_dielectric(float cosine, float ior) {
    const float inner = std::sqrt(ior * ior - 1.0f + cosine * cosine); // ior times the refracted ray's cosine
    if (inner + cosine <= 0.0f)
        return 1.0f; // grazing, of nothing
    const float across = (cosine - inner) / (cosine + inner);
    const float along = (cosine * inner - (1.0f - cosine * cosine)) / (cosine * inner + (1.0f - cosine * cosine));
    return 0.5f * across * across * (1.0f + along * along);
}
/// 0 where a surface is seen straight, 1 where its edge is: as a dielectric of that index, or, for 0, as metals.
[[nodiscard]] inline float fresnel_rise(float cosine, float ior) {
    if (ior == 0.0f) {
        const float rest = 1.0f - cosine;
        return rest * rest * rest * rest * rest;
    }
    const float straight = fresnel_dielectric(1.0f, ior);
    return std::max(0.0f, fresnel_dielectric(cosine, ior) - straight) / (1.0f - straight);
}
} // namespace tyndall
