// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/light_space.hpp"
#include "scene/light_axes.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall::light_shafts {
LightSpace::LightSpace(const Light& light, const vec3& towards, float distance_m)
    : is_flat_(light.kind == LightKind::Sun), kind_(light.kind), spot_half_angle_rad_(light.spot_half_angle_rad),
      origin_(light.position), distance_m_(distance_m) {
    const mat3 axes = light_axes(light);
    x_axis_ = axes[0], y_axis_ = axes[1], z_axis_ = axes[2];
    depth_m_ = glm::dot(towards - origin_, z_axis_);
}

std::pair<vec3, vec3> LightSpace::across(const vec3& towards_light) const {
    const vec3 x = across_of(towards_light, x_axis_);
    return {x, glm::cross(towards_light, x)};
}

vec3 LightSpace::on_plane(const vec3& p, const vec3& direction) const {
    return p + direction * ((depth_m_ - glm::dot(p, z_axis_)) / glm::dot(direction, z_axis_));
}

vec3 LightSpace::place_of(const Ray& ray) const {
    const vec3 p = is_flat_ ? on_plane(ray.origin - origin_, ray.direction)
                            : ray.origin + ray.far_m * ray.direction - origin_ - distance_m_ * ray.direction;
    return {glm::dot(p, x_axis_), glm::dot(p, y_axis_), is_flat_ ? 0.0f : glm::dot(p, z_axis_)};
}

void LightSpace::place_row(const DepthMap& face, std::int32_t row, std::vector<float>& x, std::vector<float>& y,
                           std::vector<float>& z) const {
    const slope_rows::Layout& layout = face.texels->layout;
    const auto count = static_cast<std::size_t>(layout.line_count);
    const float y_on_face = layout.first_slice + static_cast<float>(row) * layout.slice_step;
    const auto column_x = [&](std::size_t column) {
        return layout.first_line + (static_cast<float>(column) + 0.5f) * layout.line_step;
    };
    x.resize(count);
    y.resize(count);
    z.clear();
    if (is_flat_) {
        // Along the stratum's own direction onto the plane.
        const vec3 start = face.origin + column_x(0) * face.x_axis + y_on_face * face.y_axis - origin_;
        const vec3 first = on_plane(start, face.z_axis);
        // Not the difference of two rounded places: of 8,192 texels the last ones would lie a texel or two off, in each
        // row by others.
        const float along_light = glm::dot(face.x_axis, z_axis_) / glm::dot(face.z_axis, z_axis_);
        const vec3 step = layout.line_step * (face.x_axis - along_light * face.z_axis);
        const vec2 at(glm::dot(first, x_axis_), glm::dot(first, y_axis_)),
            per_column(glm::dot(step, x_axis_), glm::dot(step, y_axis_));
        for (std::size_t column = 0; column < count; ++column) {
            x[column] = at.x + static_cast<float>(column) * per_column.x;
            y[column] = at.y + static_cast<float>(column) * per_column.y;
        }
        return;
    }
    z.resize(count);
    const vec3 offset = face.origin - origin_;
    for (std::size_t column = 0; column < count; ++column) {
        const vec3 direction = column_x(column) * face.x_axis + y_on_face * face.y_axis + face.z_axis;
        const vec3 p = offset + direction * (distance_m_ / glm::length(direction));
        x[column] = glm::dot(p, x_axis_);
        y[column] = glm::dot(p, y_axis_);
        z[column] = glm::dot(p, z_axis_);
    }
}

/// Bilinear between the centres of texels; 0 outside of [0, 1]^2, unless it goes round in x.
static float bilinear(const LightMask& mask, vec2 uv, bool goes_round) {
    if (!(uv.y >= 0.0f && uv.y <= 1.0f) || (!goes_round && !(uv.x >= 0.0f && uv.x <= 1.0f)))
        return 0.0f;
    const auto width = static_cast<std::int32_t>(mask.width), height = static_cast<std::int32_t>(mask.height);
    const float x = uv.x * static_cast<float>(width) - 0.5f, y = uv.y * static_cast<float>(height) - 0.5f;
    const float column = std::floor(x), row = std::floor(y);
    const auto texel = [&](std::int32_t u, std::int32_t v) {
        u = goes_round ? (u % width + width) % width : std::clamp(u, 0, width - 1);
        return mask
            .values[static_cast<std::size_t>(std::clamp(v, 0, height - 1)) * mask.width + static_cast<std::size_t>(u)];
    };
    const auto u = static_cast<std::int32_t>(column), v = static_cast<std::int32_t>(row);
    return std::lerp(std::lerp(texel(u, v), texel(u + 1, v), x - column),
                     std::lerp(texel(u, v + 1), texel(u + 1, v + 1), x - column), y - row);
}

float LightSpace::look_up(const LightMask& mask, const vec3& place_m) const {
    if (kind_ == LightKind::Sun) {
        const float height_m = mask.size_m * static_cast<float>(mask.height) / static_cast<float>(mask.width);
        return bilinear(mask, vec2(place_m) / vec2(mask.size_m, height_m) + 0.5f, false);
    }
    if (kind_ == LightKind::Spot) {
        if (!(place_m.z < 0.0f))
            return 0.0f;
        const float tangent = std::tan(std::min(spot_half_angle_rad_, 0.499f * pi));
        return bilinear(mask, vec2(place_m) / (-place_m.z * tangent) * 0.5f + 0.5f, false);
    }
    const float elevation = std::atan2(place_m.z, glm::length(vec2(place_m)));
    return bilinear(mask, {std::atan2(place_m.y, place_m.x) / (2 * pi) + 0.5f, elevation / pi + 0.5f}, true);
}
} // namespace tyndall::light_shafts
