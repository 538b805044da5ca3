// SPDX-License-Identifier: GPL-3.0-or-later
// Which points a light cannot reach, whatever part of it shines: known before any of it is sampled.
// Bound:    a dozen operations per point; 40 for a spot.
#pragma once
#include "scene/light.hpp"

namespace tyndall::render {
class LightReach {
public:
    explicit LightReach(const Light& light);

    /// False only where the whole light stands behind the plane through the point, or shines past it.
    [[nodiscard]] bool may_light(const vec3& position, const vec3& shading_normal) const {
        if (is_sun_)
            return glm::dot(towards_light_, shading_normal) > -margin_;
        const vec3 way = position - position_;
        return glm::dot(way, shading_normal) < margin_ && (!is_spot_ || may_shine_on(way));
    }

private:
    [[nodiscard]] bool may_shine_on(const vec3& way) const;

    bool is_sun_, is_spot_;
    vec3 towards_light_, position_;
    float margin_;               ///< Sun: sine of its half angle. Local: its radius. Both with what rounding may add.
    mat3 cone_from_world_{1.0f}; ///< Into a space where the spot's axis is -Z and its cone round.
    float cone_radius_ = 0.0f;   ///< Of the sphere around the light there.
    float cos_half_ = 0.0f, sin_half_ = 0.0f;
};
} // namespace tyndall::render
