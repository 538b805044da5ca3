// SPDX-License-Identifier: GPL-3.0-or-later
// What bumps take from light that comes in flat: a lobe with a normal of its own would else go dark at a sharp line, where
// the surface below it turns from the light.
// Based on: Chiang, Li, Burley, Taming the Shadow Terminator, SIGGRAPH Talks 2019; Conty Estevez, Lecocq, Stein, A
//           Microfacet-Based Shadowing Function to Solve the Bump Terminator Problem, Ray Tracing Gems, chapter 12, 2019.
#pragma once
#include "core/math.hpp"
#include "shading/lobes/ggx.hpp"
#include <cstdint>

namespace tyndall {
enum class BumpShadowing : std::uint8_t {
    None = 0,
    Smooth = 1, ///< Chiang's, as up to Blender 3.x.
    Facets = 2, ///< Conty's, from 4.0 on.
    Count = 3,
};

/// Share of light that stays. Cosines, all positive: of light and surface, of light and the own normal, of both normals.
[[nodiscard]] inline float unshadowed_by_bumps(BumpShadowing kind, float light, float own_light, float between) {
    if (kind == BumpShadowing::None)
        return 1.0f;
    if (kind == BumpShadowing::Smooth) {
        const float rise = light / std::max(own_light * between, 1e-12f);
        return rise >= 1.0f ? 1.0f : rise * (1.0f + rise * (1.0f - rise));
    }
    if (light >= 1.0f || between >= 1.0f)
        return 1.0f;
    const float slope2 = 1.0f / (between * between) - 1.0f;
    return ggx::masking(std::sqrt(std::min(0.125f * slope2, 1.0f)), std::max(light, 1e-6f));
}
} // namespace tyndall
