// SPDX-License-Identifier: GPL-3.0-or-later
// Phase functions: how a medium spreads the light that it scatters once.
// Based on: Henyey and Greenstein, Diffuse Radiation in the Galaxy, Astrophysical Journal 93, 1941; Draine, Scattering by
//           Interstellar Dust Grains I, Astrophysical Journal 598, 2003, eq. 5: that times 1 + alpha cos^2, of which
//           Rayleigh's (g 0, alpha 1) and Cornette and Shanks' (alpha 1) are members.
// Differs:  the denominator 1 + g^2 - 2 g cos is written as (1 - |g|)^2 + 2 |g| (1 - sign(g) cos): near the peak of a
//           narrow lobe the printed form cancels, and at g = 0.999 it is 10 % off in float32.
// Bound:    one square root and one division.
#pragma once
#include "core/math.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tyndall {
/// Share of the scattered light per steradian; its integral over all directions is 1.
/// @param cosine       Between the light's way and the way on, [-1, 1]; 1 is straight on.
/// @param asymmetry_g  Mean cosine, (-1, 1); positive scatters forward.
[[nodiscard]] inline float henyey_greenstein_per_sr(float cosine, float asymmetry_g) {
    const float g = std::abs(asymmetry_g), forward = std::copysign(1.0f, asymmetry_g) * cosine;
    const float denominator = (1.0f - g) * (1.0f - g) + 2.0f * g * (1.0f - forward);
    const float peak = (1.0f - g) * (1.0f + g) * 0.25f * std::numbers::inv_pi_v<float>;
    return peak / (denominator * std::sqrt(denominator));
}

/// What Draine's factor 1 + alpha cos^2 makes of all light that Henyey and Greenstein's function scatters.
[[nodiscard]] constexpr float draine_total(float asymmetry_g, float alpha) {
    return 1.0f + alpha * (1.0f + 2.0f * asymmetry_g * asymmetry_g) / 3.0f;
}

/// As henyey_greenstein_per_sr, which it is where alpha is 0.
[[nodiscard]] inline float draine_per_sr(float cosine, float asymmetry_g, float alpha) {
    const float base = henyey_greenstein_per_sr(cosine, asymmetry_g);
    return alpha == 0.0f ? base : base * (1.0f + alpha * cosine * cosine) / draine_total(asymmetry_g, alpha);
}

/// Cosine to straight on, distributed as Henyey and Greenstein's light is.
/// @param u  In [0, 1); 0 is straight on.
[[nodiscard]] inline float sample_henyey_greenstein_cosine(float asymmetry_g, float u) {
    const float g = asymmetry_g;
    if (std::abs(g) < 1e-3f)
        return 1.0f - 2.0f * u;
    const float ratio = (1.0f - g * g) / (1.0f + g - 2.0f * g * u);
    return std::clamp((1.0f + g * g - ratio * ratio) / (2.0f * g), -1.0f, 1.0f);
}
} // namespace tyndall
