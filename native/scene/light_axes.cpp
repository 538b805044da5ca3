// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/light_axes.hpp"

namespace tyndall {
vec3 across_of(const vec3& z, const vec3& x) {
    const vec3 rest = x - glm::dot(x, z) * z;
    const float length = glm::length(rest);
    return length > 1e-3f * glm::length(x) ? rest / length : orthonormal_basis(z).first;
}

mat3 light_axes(const Light& light) {
    const mat3 axes = glm::transpose(light.light_from_world_directions);
    const vec3 z = light.kind == LightKind::Sun                                     ? light.towards_light
                   : light.kind == LightKind::Spot || light.kind == LightKind::Area ? -light.spot_axis
                                                                                    : glm::normalize(axes[2]);
    const vec3 x = across_of(z, axes[0]);
    return {x, glm::cross(z, x), z};
}
} // namespace tyndall
