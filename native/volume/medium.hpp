// SPDX-License-Identifier: GPL-3.0-or-later
// A participating medium, as Blender's volume shaders describe it; one Blender unit is one metre.
#pragma once
#include "core/math.hpp"
#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

namespace tyndall {
/// Scattering with one phase function, Draine's; without its alpha, Henyey and Greenstein's. A medium made of several
/// scatter nodes has several lobes.
struct ScatterLobe {
    Rgb sigma_s_per_m{0.0f};   ///< Scattering coefficient per channel, [0, 1e6].
    float asymmetry_g = 0.0f;  ///< (-1, 1); positive scatters forward.
    float draine_alpha = 0.0f; ///< [0, 1e6]: of the squared cosine; see phase_function.hpp.
};

struct Medium {
    std::string name; ///< Of the material or world, for reports.
    std::vector<ScatterLobe> lobes = {};
    Rgb sigma_a_per_m{0.0f};        ///< Absorption coefficient per channel, [0, 1e6].
    Rgb emission_w_per_m3_sr{0.0f}; ///< Emitted radiance per metre.
    std::uint8_t receiver_set = 0;  ///< Of the objects that hold it: which emitters light it, see LightLinks.

    [[nodiscard]] Rgb sigma_s_per_m() const {
        Rgb sum{0.0f};
        for (const ScatterLobe& lobe : lobes)
            sum += lobe.sigma_s_per_m;
        return sum;
    }
    [[nodiscard]] Rgb sigma_t_per_m() const { return sigma_s_per_m() + sigma_a_per_m; }
};

/// In how many metres a medium lets through no more than 1e-7, in each channel that it dims; 0: it dims none.
[[nodiscard]] inline float opaque_within_m(const Rgb& sigma_t_per_m) {
    constexpr float optical_depth = 16.0f;
    float far_m = 0.0f;
    for (int channel = 0; channel < 3; ++channel)
        if (sigma_t_per_m[channel] > 0.0f)
            far_m = std::max(far_m, optical_depth / sigma_t_per_m[channel]);
    return far_m;
}
} // namespace tyndall
