// SPDX-License-Identifier: GPL-3.0-or-later
// Where the view rays of one local light sample read the light's picture.
// Bound:    a slide that is thrown is read along a straight line: three products and a quotient per point.
#pragma once
#include "scene/light_texture.hpp"

namespace tyndall::light_shafts {
class PictureAlongRay {
public:
    /// `light` has a texture that is not planar, and must outlive this.
    PictureAlongRay(const Light& light, const vec3& emitter);
    /// Distances along the ray are measured from `foot`, its point nearest to the emitter.
    void begin_ray(const vec3& foot, const vec3& direction);
    [[nodiscard]] vec2 uv(float x) const;
    /// How many texels lie between the first and the last of three places, which the light sees `angle_rad` apart.
    [[nodiscard]] float texels(float first, float middle, float last, float angle_rad) const;
    [[nodiscard]] const LightTexture& texture() const { return texture_; }

private:
    const LightTexture& texture_;
    vec3 emitter_;
    bool is_thrown_;          ///< Homogeneous coordinates are linear along the ray.
    mat3 from_way_;           ///< Of the way from the emitter: to those, or to the picture's axes.
    vec3 at_foot_, per_m_{0}; ///< Along the ray.
    bool is_constant_;        ///< The emitter's normal tells, which is one for all points.
};
} // namespace tyndall::light_shafts
