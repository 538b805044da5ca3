// SPDX-License-Identifier: GPL-3.0-or-later
// How a picture lies across light that falls in parallel: the colour of a point is that of all points along the light.
#pragma once
#include "core/math.hpp"

namespace tyndall {
/// Texture coordinates of points in the scene's space; uv in [0, 1]^2 is the picture once.
struct PlanarPlacement {
    vec3 u_per_m{1, 0, 0}, v_per_m{0, 1, 0}; ///< Gradients of u and v.
    vec2 uv_at_origin{0.0f};
    [[nodiscard]] vec2 uv(const vec3& point) const { return uv_at_origin + uv_per_m(point); }
    /// Along a unit direction.
    [[nodiscard]] vec2 uv_per_m(const vec3& direction) const {
        return {glm::dot(u_per_m, direction), glm::dot(v_per_m, direction)};
    }
};
} // namespace tyndall
