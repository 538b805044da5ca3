// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/picture_along_ray.hpp"

namespace tyndall::light_shafts {
PictureAlongRay::PictureAlongRay(const Light& light, const vec3& emitter)
    : texture_(*light.texture), emitter_(emitter),
      is_thrown_(texture_.projection == LightProjection::Perspective && texture_.place_from_axes[3] == vec3(0.0f)),
      from_way_(texture_.axes_from_world), at_foot_(0.0f),
      is_constant_(texture_.follows_normal && light.body == LightBody::Sphere && light.radius_m > 0.0f) {
    if (is_thrown_)
        from_way_ = texture_.uv_from_projected * mat3(texture_.place_from_axes) * texture_.axes_from_world;
    if (is_constant_)
        at_foot_ = from_way_ * (emitter - light.position);
}

void PictureAlongRay::begin_ray(const vec3& foot, const vec3& direction) {
    if (is_constant_)
        return;
    at_foot_ = from_way_ * (foot - emitter_);
    per_m_ = from_way_ * direction;
}

vec2 PictureAlongRay::uv(float x) const {
    const vec3 at = at_foot_ + x * per_m_;
    if (!is_thrown_)
        return uv_of_axes(texture_, at);
    return at.z != 0.0f ? vec2(at) / at.z : vec2(0.0f);
}

float PictureAlongRay::texels(float first, float middle, float last, float angle_rad) const {
    // By the angle, that neither the seam, where u jumps, nor the poles, where it is crowded, count for more.
    if (texture_.projection == LightProjection::Directions)
        return is_constant_ ? 0.0f : angle_rad / texel_rad(texture_);
    const vec2 size = texture_.image->size(), at_middle = uv(middle);
    return glm::length((at_middle - uv(first)) * size) + glm::length((uv(last) - at_middle) * size);
}
} // namespace tyndall::light_shafts
