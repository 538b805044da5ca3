// SPDX-License-Identifier: GPL-3.0-or-later
// Colours that a facet reflects, by the cosine of the light on it.
// Based on: Fresnel's equations; Kutz, Hasan, Edmondson, Novel Aspects of the Adobe Standard Material, 2021 (F82-tint);
//           Kulla and Conty, Revisiting Physically Based Shading at Imageworks, SIGGRAPH 2017 course notes (means).
#pragma once
#include "core/math.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall {
/// Share seen straight, and the index that has it, at least 1.
[[nodiscard]] inline float straight_share(float ior) {
    const float root = (ior - 1.0f) / (ior + 1.0f);
    return root * root;
}
[[nodiscard]] inline float ior_of_straight_share(float share) {
    const float root = std::sqrt(std::clamp(share, 0.0f, 0.99f));
    return (1.0f + root) / (1.0f - root);
}
/// Unpolarised, of any relative index above 0: from inside, below 1, all beyond the critical angle.
[[nodiscard]] inline float fresnel_of_any_index(float cosine, float ior) {
    const float inner2 = ior * ior - 1.0f + cosine * cosine;
    if (inner2 <= 0.0f)
        return 1.0f;
    const float inner = std::sqrt(inner2);
    const float across = (inner - cosine) / (inner + cosine);
    const float along = (cosine * (inner + cosine) - 1.0f) / (cosine * (inner - cosine) + 1.0f);
    return 0.5f * across * across * (1.0f + along * along);
}
/// 0 where a facet is seen straight, 1 where its edge is.
[[nodiscard]] inline float fresnel_rise_of_any_index(float cosine, float ior) {
    const float straight = straight_share(ior);
    return std::clamp((fresnel_of_any_index(cosine, ior) - straight) / (1.0f - straight), 0.0f, 1.0f);
}
/// Schlick's rise from `straight`, less `dark` where metals are darker than that: around 82 degrees.
[[nodiscard]] inline Rgb fresnel_f82(float cosine, const Rgb& straight, const Rgb& dark) {
    const float rest = std::clamp(1.0f - cosine, 0.0f, 1.0f), rest5 = rest * rest * rest * rest * rest;
    return glm::clamp(glm::mix(straight, Rgb(1.0f), rest5) - dark * (cosine * rest5 * rest), 0.0f, 1.0f);
}
/// Schlick's share where the cosine is 1 / 7, and the `dark` with which a metal has `edge` there.
[[nodiscard]] inline Rgb f82_schlick(const Rgb& straight) {
    constexpr float rest = 6.0f / 7.0f;
    return glm::mix(straight, Rgb(1.0f), rest * rest * rest * rest * rest);
}
[[nodiscard]] inline Rgb f82_dark_of_edge(const Rgb& straight, const Rgb& edge) {
    constexpr float rest2 = (6.0f / 7.0f) * (6.0f / 7.0f);
    return (f82_schlick(straight) - edge) * (7.0f / (rest2 * rest2 * rest2));
}
/// The same with `tint` of Schlick's share.
[[nodiscard]] inline Rgb f82_dark(const Rgb& straight, const Rgb& tint) {
    return f82_dark_of_edge(straight, f82_schlick(straight) * tint);
}
/// Of complex index n + i k.
[[nodiscard]] inline Rgb fresnel_conductor(float cosine, const Rgb& n, const Rgb& k) {
    const float cosine2 = cosine * cosine;
    const Rgb size2 = n * n + k * k, twice = 2.0f * cosine * n;
    const Rgb along = (size2 * cosine2 - twice + 1.0f) / (size2 * cosine2 + twice + 1.0f);
    const Rgb across = (size2 - twice + cosine2) / (size2 + twice + cosine2);
    return 0.5f * (along + across);
}
/// Means over the hemisphere by the cosine, 2 integral of F cos.
[[nodiscard]] inline float mean_fresnel(float ior) {
    if (ior < 1.0f)
        return 0.997118f + ior * (0.1014f - ior * (0.965241f + ior * 0.130607f));
    return (ior - 1.0f) / (4.08567f + 1.00071f * ior);
}
[[nodiscard]] inline Rgb mean_f82(const Rgb& straight, const Rgb& dark) {
    return glm::mix(straight, Rgb(1.0f), 1.0f / 21.0f) - dark * (1.0f / 126.0f);
}
} // namespace tyndall
