// SPDX-License-Identifier: GPL-3.0-or-later
// Lights with a size as strata without one, with the shape of Cycles' lights (blender/cycles, src/kernel/light).
// Based on: 3.x: light.h and common.h of v3.4.0; 4.x and 5.x: spot.h, point.h and distant.h of v4.5.0, v5.0.0. Measured
//           in Blender 3.4.1, 4.5.15 and 5.0.1; tests/native/scene/light_test.cpp holds the figures.
// Differs:  Cycles turns a disc towards each receiver; shadow maps and slices need strata that stand still. Points of the
//           ball with density 1 / sqrt(r^2 - rho^2), the shadow of a uniform 3-sphere, look like that disc from every
//           side. With 1 / (D^2 + rho^2), D from the ball's centre, their fluence is exactly the disc's at any distance:
//           2 (1 - D / sqrt(D^2 + r^2)) / r^2, term by term. What remains is a penumbra that is off by (r / D)^2;
//           where something stands in the ball, see light_shafts/turning_disc.hpp.
#include "scene/light.hpp"
#include "core/sampling.hpp"
#include "scene/area_light.hpp"
#include "scene/light_texture.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tyndall {
static float smoothstep(float x) {
    const float clamped = std::clamp(x, 0.0f, 1.0f);
    return clamped * clamped * (3.0f - 2.0f * clamped);
}

float spot_attenuation(const Light& light, const vec3& from_light) {
    if (light.kind != LightKind::Spot)
        return 1.0f;
    const float cos_half = std::cos(light.spot_half_angle_rad);
    const float smooth = (1.0f - cos_half) * light.spot_blend;
    if (light.spot_falloff == SpotFalloff::Blender3) {
        // The cosine itself stays a factor up to 3.x, also with blend 0.
        const float cosine = glm::dot(from_light, light.spot_axis);
        if (cosine <= cos_half)
            return 0.0f;
        return smooth > 0.0f ? cosine * smoothstep((cosine - cos_half) / smooth) : cosine;
    }
    const vec3 in_light = light.light_from_world_directions * from_light;
    const float cosine = -in_light.z / glm::length(in_light);
    if (smooth > 0.0f)
        return smoothstep((cosine - cos_half) / smooth);
    return cosine > cos_half ? 1.0f : 0.0f;
}

Rgb intensity_w_per_sr(const LightSample& sample, const vec3& from_light) {
    Rgb intensity = sample.strength;
    if (sample.spot != nullptr && sample.spot->kind == LightKind::Area)
        return intensity * area_spread(*sample.spot)
                               .lobe(glm::dot(sample.emission_normal, from_light),
                                     glm::length(glm::cross(sample.emission_normal, from_light)));
    if (sample.emission_normal != vec3(0.0f))
        intensity *= std::max(0.0f, glm::dot(sample.emission_normal, from_light));
    if (sample.spot != nullptr)
        intensity *= spot_attenuation(*sample.spot, from_light);
    return intensity;
}

float irradiance_per_intensity(const LightSample& sample, const vec3& point) {
    const vec3 way = point - sample.position - sample.falloff_offset;
    const float distance2 = glm::dot(way, way), softened2 = distance2 + sample.softening_m2;
    return sample.faces_receivers ? std::sqrt(distance2 / softened2) / softened2 : 1.0f / softened2;
}

/// What an area light shows is in the strength of its samples.
static bool is_textured_sample(const Light& light) {
    return light.texture && (light.kind != LightKind::Area || changes_with_distance(*light.texture));
}

/// What all samples of a light have in common; complete for a light without a size.
static LightSample centre_sample(const Light& light, std::uint32_t light_index) {
    return {.is_directional = light.kind == LightKind::Sun,
            .towards_light = light.towards_light,
            .position = light.position,
            .strength = light.strength,
            .emission_normal = light.kind == LightKind::Area ? light.spot_axis : vec3(0.0f),
            .spot = light.kind == LightKind::Spot || light.kind == LightKind::Area ? &light : nullptr,
            .textured = is_textured_sample(light) ? &light : nullptr,
            .light_index = light_index,
            .casts_shadow = light.casts_shadow,
            .is_dimmed_by_media = light.is_dimmed_by_media()};
}

static LightSample sample_sun(const Light& light, LightSample sample, vec2 u) {
    if (light.body == LightBody::FacingDisc) {
        // Each stratum lights planes that face it alike; the disc's centre sees them under a mean cosine of 2 c / (1 + c).
        const float half_angle_rad = std::min(light.half_angle_rad, 1.57f);
        const float cos_half = std::cos(half_angle_rad);
        const vec2 disc = std::tan(half_angle_rad) * sample_concentric_disc(u);
        sample.towards_light = glm::normalize(from_frame(light.towards_light, vec3(disc, 1.0f)));
        sample.strength *= (1.0f + cos_half) / (2.0f * cos_half);
        return sample;
    }
    const float one_minus_cos_half = one_minus_cos(light.half_angle_rad);
    sample.towards_light = from_frame(light.towards_light, sample_uniform_cone(u, one_minus_cos_half));
    // The disc's radiance E / (pi sin^2) times its solid angle 2 pi (1 - cos): a stratum weighs more than E, because a
    // plane that faces the disc's centre sees its rim under a cosine.
    sample.strength *= 2.0f / (2.0f - one_minus_cos_half);
    return sample;
}

LightSample sample_light(const Light& light, std::uint32_t light_index, const vec3& u) {
    LightSample sample = centre_sample(light, light_index);
    if (light.kind == LightKind::Sun)
        return light.half_angle_rad > 0.0f ? sample_sun(light, sample, vec2(u)) : sample;
    if (light.kind == LightKind::Area) {
        sample.position = area_point(light, vec2(u));
        sample.strength *= area_spread(light).gain;
        return sample;
    }
    if (light.radius_m <= 0.0f)
        return sample;
    if (light.body == LightBody::Sphere) {
        sample.emission_normal = sample_uniform_sphere(vec2(u));
        sample.position += light.radius_m * sample.emission_normal;
        sample.strength *= 4.0f; // the mean of max(0, cos) over the sphere is 1/4
        return sample;
    }
    const vec2 disc = sample_concentric_disc(vec2(u));
    const float angle = 2.0f * std::numbers::pi_v<float> * u.z;
    const float depth = std::sqrt(std::max(0.0f, 1.0f - glm::dot(disc, disc))) * std::cos(angle);
    sample.falloff_offset = -light.radius_m * from_frame(light.spot_axis, vec3(disc, depth));
    sample.position -= sample.falloff_offset;
    sample.softening_m2 = glm::dot(sample.falloff_offset, sample.falloff_offset);
    return sample;
}

LightSample sample_light_towards(const Light& light, std::uint32_t light_index, vec2 u, const vec3& receiver) {
    LightSample sample = centre_sample(light, light_index);
    if (light.kind == LightKind::Area) {
        const AreaPoint towards = area_point_towards(light, u, receiver);
        sample.position = towards.position;
        sample.strength *= towards.share;
        return sample;
    }
    const vec3 way = receiver - light.position;
    const float distance_m = glm::length(way);
    if (light.kind == LightKind::Sun || light.radius_m <= 0.0f || !(distance_m > 0.0f))
        return sample_light(light, light_index, vec3(u, 0.0f));
    const vec3 axis = way / distance_m;
    const float radius_m = light.radius_m;
    if (light.body == LightBody::FacingDisc) {
        sample.position += radius_m * from_frame(axis, vec3(sample_concentric_disc(u), 0.0f));
        sample.emission_normal = axis;
        return sample;
    }
    if (distance_m <= radius_m)
        return sample;
    // Uniform in the cone that the sphere fills: radiance I / (pi r^2) times its solid angle, as an intensity at the
    // distance of the point where the direction meets the sphere.
    const float sin2_half = (radius_m / distance_m) * (radius_m / distance_m);
    const float one_minus_cos_half = sin2_half / (1.0f + std::sqrt(1.0f - sin2_half));
    const vec3 local = sample_uniform_cone(u, one_minus_cos_half);
    const vec3 from_receiver = from_frame(-axis, local);
    const float half_chord2 =
        std::max(0.0f, radius_m * radius_m - distance_m * distance_m * (1.0f - local.z * local.z));
    const float to_surface_m = distance_m * local.z - std::sqrt(half_chord2);
    const float solid_angle_sr = 2.0f * std::numbers::pi_v<float> * one_minus_cos_half;
    sample.position = receiver + to_surface_m * from_receiver;
    sample.strength *= solid_angle_sr * to_surface_m * to_surface_m / (std::numbers::pi_v<float> * radius_m * radius_m);
    return sample;
}
} // namespace tyndall
