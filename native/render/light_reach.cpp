// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/light_reach.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tyndall::render {
/// What rounding may add to a quantity of size 1.
static constexpr float rounding = 1e-5f;

/// An upper bound of how much a matrix lengthens a vector.
static float largest_stretch(const mat3& matrix) {
    return std::sqrt(glm::dot(matrix[0], matrix[0]) + glm::dot(matrix[1], matrix[1]) + glm::dot(matrix[2], matrix[2]));
}

LightReach::LightReach(const Light& light)
    : is_sun_(light.kind == LightKind::Sun), is_spot_(light.kind == LightKind::Spot),
      towards_light_(light.towards_light), position_(light.position) {
    if (is_sun_) {
        const bool is_hemisphere = light.half_angle_rad >= 0.5f * std::numbers::pi_v<float>;
        margin_ = rounding + (is_hemisphere ? 1.0f : std::sin(light.half_angle_rad));
        return;
    }
    margin_ = light.radius_m * (1.0f + rounding);
    if (!is_spot_)
        return;
    if (light.spot_falloff == SpotFalloff::Blender3) {
        const auto [tangent, bitangent] = orthonormal_basis(-light.spot_axis);
        cone_from_world_ = glm::transpose(mat3(tangent, bitangent, -light.spot_axis));
    } else {
        cone_from_world_ = light.light_from_world_directions;
    }
    cone_radius_ = largest_stretch(cone_from_world_) * margin_;
    cos_half_ = std::cos(light.spot_half_angle_rad);
    sin_half_ = std::sin(light.spot_half_angle_rad);
}

/// Whether the sphere in which the light stands meets the cone that opens from the point to all places from which the
/// spot would shine on it: the same cone as the light's, turned round.
bool LightReach::may_shine_on(const vec3& way) const {
    const vec3 in_cone = cone_from_world_ * way;
    const float along = -in_cone.z;
    const float across2 = in_cone.x * in_cone.x + in_cone.y * in_cone.y;
    const float outside_by = std::sqrt(across2) * cos_half_ - along * sin_half_;
    return outside_by <= cone_radius_ + rounding * std::sqrt(across2 + along * along);
}
} // namespace tyndall::render
