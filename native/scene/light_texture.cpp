// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/light_texture.hpp"
#include "core/errors.hpp"
#include "scene/light_axes.hpp"
#include <algorithm>
#include <numbers>

namespace tyndall {
static bool is_finite(const mat3& matrix) {
    bool result = true;
    for (int column = 0; column < 3; ++column)
        result = result && std::isfinite(matrix[column].x + matrix[column].y + matrix[column].z);
    return result;
}

void require_usable(const LightTexture& texture) {
    constexpr float largest_m = 1e6f, smallest_m = 1e-6f;
    require(texture.image != nullptr, "it has no image");
    require(texture.projection <= LightProjection::Directions, "projection ", static_cast<int>(texture.projection),
            " is unknown");
    require_in(texture.size_m.x, smallest_m, largest_m, "size_m");
    require_in(texture.size_m.y, smallest_m, largest_m, "height in metres");
    require(is_finite(mat3(vec3(texture.centre_m, 0.0f), vec3(0.0f), vec3(0.0f))), "its centre is not finite");
    require(is_finite(texture.axes_from_world) && is_finite(mat3(texture.place_from_axes)) &&
                is_finite(mat3(texture.place_from_axes[3], vec3(0.0f), vec3(0.0f))) &&
                is_finite(texture.uv_from_projected),
            "its mapping is not finite");
    constexpr float most_smooth_m2 = 1e12f;
    require(texture.distance_power <= 2, "distance to the power of ", int{texture.distance_power});
    require_in(texture.smooth_m2, 0.0f, most_smooth_m2, "smooth_m2");
    require(!changes_with_distance(texture) || texture.projection != LightProjection::Planar,
            "suns do not change with the distance");
    require(is_finite(mat3(texture.offset, vec3(0.0f), vec3(0.0f))) && is_finite(texture.gain),
            "its colours are not finite");
}

LightTexture thrown_by(const Light& lamp) {
    LightTexture thrown{.axes_from_world = lamp.light_from_world_directions};
    if (lamp.kind == LightKind::Spot) {
        const float half_cotangent = 0.5f / std::tan(lamp.spot_half_angle_rad);
        thrown.projection = LightProjection::Perspective;
        thrown.place_from_axes = {vec3(half_cotangent, 0, 0), vec3(0, half_cotangent, 0), vec3(-0.5f, -0.5f, -1.0f),
                                  vec3(0.0f)};
    } else {
        thrown.projection = LightProjection::Sphere;
        thrown.follows_normal = true;
    }
    return thrown;
}

PlanarPlacement planar_placement(const Light& sun, const LightTexture& texture) {
    const mat3 axes = light_axes(sun);
    PlanarPlacement placement{.u_per_m = axes[0] / texture.size_m.x, .v_per_m = axes[1] / texture.size_m.y};
    placement.uv_at_origin = 0.5f - texture.centre_m / texture.size_m - placement.uv_per_m(sun.position);
    return placement;
}

/// As Cycles' map_to_sphere.
static vec2 on_sphere(const vec3& place) {
    constexpr float per_turn = 0.5f * std::numbers::inv_pi_v<float>;
    const float latitude = std::atan2(place.z, glm::length(vec2(place)));
    return {0.5f - per_turn * std::atan2(place.x, place.y), 0.5f + 2.0f * per_turn * latitude};
}

static vec2 projected(LightProjection projection, const vec3& place) {
    if (projection == LightProjection::Sphere || projection == LightProjection::Directions)
        return on_sphere(place);
    if (projection == LightProjection::Perspective)
        return place.z != 0.0f ? vec2(place) / place.z : vec2(0.0f); // a Divide node gives 0, too
    return vec2(place);
}

float texel_rad(const LightTexture& texture) {
    // The projected v runs from 0 to 1 over half a turn.
    return std::numbers::pi_v<float> / (std::abs(texture.uv_from_projected[1].y) * texture.image->size().y);
}

vec2 uv_of_axes(const LightTexture& texture, const vec3& axes) {
    const vec3 place = texture.place_from_axes * vec4(glm::normalize(axes), 1.0f);
    return vec2(texture.uv_from_projected * vec3(projected(texture.projection, place), 1.0f));
}

static vec2 on_emitter(const Light& light, const vec3& emitter) {
    const mat3 axes = light_axes(light);
    const vec3 way = emitter - light.position;
    return 0.5f + 0.5f * vec2(glm::dot(way, axes[0]), glm::dot(way, axes[1])) / light.half_size_m;
}

vec2 texture_uv(const Light& light, const vec3& emitter, const vec3& point) {
    const LightTexture& texture = *light.texture;
    if (texture.projection == LightProjection::Emitter)
        return vec2(texture.uv_from_projected * vec3(on_emitter(light, emitter), 1.0f));
    if (texture.projection == LightProjection::Planar)
        return planar_placement(light, texture).uv(point);
    const bool has_normal = texture.follows_normal && light.body == LightBody::Sphere && light.radius_m > 0.0f;
    const vec3 vector = light.kind == LightKind::Sun ? -light.towards_light
                        : has_normal                 ? emitter - light.position
                                                     : point - emitter;
    return uv_of_axes(texture, texture.axes_from_world * vector);
}

Rgb texture_colour(const Light& light, const vec3& emitter, const vec3& point) {
    if (!light.texture)
        return Rgb(1.0f);
    const Rgb colour = light.texture->colour(texture_uv(light, emitter, point));
    const vec3 way = point - emitter;
    return changes_with_distance(*light.texture) ? colour * distance_share(*light.texture, glm::dot(way, way)) : colour;
}

Rgb texture_colour(const LightSample& sample, const vec3& point) {
    const Light& light = *sample.textured;
    if (light.kind != LightKind::Area)
        return texture_colour(light, sample.is_directional ? point + sample.towards_light : sample.position, point);
    const vec3 way = point - sample.position;
    return Rgb(distance_share(*light.texture, glm::dot(way, way)));
}

Rgb mean_colour(const Light& light, const vec3& emitter, std::uint32_t part_count) {
    const LightTexture& texture = *light.texture;
    const vec2 size = texture.image->size();
    const float texels =
        part_count == 1 ? std::max(size.x, size.y) : std::sqrt(size.x * size.y / static_cast<float>(part_count));
    return texture.colour(texture_uv(light, emitter, emitter), texels);
}
} // namespace tyndall
