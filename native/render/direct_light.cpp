// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/direct_light.hpp"
#include "core/sampling.hpp"
#include "render/shadow_terminator.hpp"
#include "shading/surface_program.hpp"
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>

namespace tyndall::render {
static constexpr float pi = std::numbers::pi_v<float>;

DirectLight::DirectLight(const Scene& scene, const Media& media, Statistics& statistics)
    : scene_(scene), media_(media), has_media_(!media.is_empty()), has_world_light_(!scene.world().is_black()) {
    for (std::uint32_t index = 0; index < scene.lights().size(); ++index) {
        const Light& light = scene.lights()[index];
        if (!light.lights_surfaces || light.strength == Rgb(0.0f))
            continue;
        lights_.push_back({index, LightAim(light)});
        if (light.kind == LightKind::Sun && media.fills_world())
            statistics.report("Light \"" + light.name +
                              "\" is infinitely far away in the world's endless medium, which lets nothing of it "
                              "through: bound the fog with a fog box");
    }
    // Seen by the camera, as it should be; what it would send to other surfaces is left out, and said.
    std::vector<bool> is_used(scene.description().materials.size());
    for (const Instance& instance : scene.description().instances)
        for (std::uint32_t slot = 0; slot < instance.slot_count; ++slot)
            is_used[scene.description().slot_materials[instance.first_slot_material + slot]] = true;
    for (std::size_t index = 0; index < is_used.size(); ++index)
        if (const Material& material = scene.description().materials[index]; is_used[index] && !glows_nowhere(material))
            statistics.report("Material \"" + material.name + "\" glows, but lights no other surface and no fog");
    if (has_world_light_ && media.fills_world())
        statistics.report("World \"" + scene.world().name() +
                          "\" shines through its own endless medium, which lets nothing through: bound the fog with a "
                          "fog box");
}

Ray DirectLight::shadow_ray(const SurfacePoint& point, const vec3& direction) const {
    Ray ray{.origin = point.spawn.towards(direction), .direction = direction};
    if (point.is_smooth)
        ray.origin += terminator_lift(scene_, point.hit, point.shading, direction);
    return ray;
}

void DirectLight::at(std::span<const SurfacePoint> points, const PairIndex& first_pair,
                     std::span<Irradiance> irradiance) const {
    std::fill_n(irradiance.begin(), points.size(), Irradiance{});
    LitPoints lanes;
    for (std::size_t lane = 0; lane < points.size(); ++lane) {
        const SurfacePoint& point = points[lane];
        lanes.set(lane, point.shading.position, point.shading.shading_normal, point.spawn, point.pixel_seed);
    }
    // A light has the same pair wherever it shines: what one point skips does not shift another light's numbers.
    PairIndex pair = first_pair;
    for (const AimedLight& light : lights_) {
        add_light(light, points, lanes, pair, irradiance);
        ++pair.pair_index;
    }
    if (has_world_light_)
        for (std::size_t index = 0; index < points.size(); ++index)
            irradiance[index].from_world = world_irradiance(points[index], pair);
}

void DirectLight::finish(const Light& light, const SurfacePoint& point, Ray& ray, Rgb& arriving) const {
    if (light.kind == LightKind::Spot)
        arriving *= spot_attenuation(light, -ray.direction);
    if (!point.is_smooth)
        return;
    const vec3 lift = terminator_lift(scene_, point.hit, point.shading, ray.direction);
    if (lift == vec3(0.0f))
        return;
    const vec3 target = ray.origin + ray.far_m * ray.direction;
    ray.origin += lift;
    if (light.kind == LightKind::Sun)
        return;
    const vec3 to_light = target - ray.origin;
    ray.far_m = glm::length(to_light);
    ray.direction = to_light / ray.far_m;
}

/// Rays of several points towards one light.
struct DirectLight::ShadowRays {
    std::array<Ray, most_points> rays;
    std::array<Rgb, most_points> arriving; ///< With nothing between, times the cosine.
    std::array<Rgb, most_points> passing;
    std::array<std::uint8_t, most_points> points;
    std::size_t count = 0;
};

void DirectLight::add_light(const AimedLight& aimed, std::span<const SurfacePoint> points, const LitPoints& lanes,
                            const PairIndex& pair, std::span<Irradiance> irradiance) const {
    if (aimed.aim.may_light(lanes) == 0)
        return;
    const Light& light = scene_.lights()[aimed.index];
    AimedRays towards;
    ShadowRays shadow;
    for (LaneSet left = aimed.aim.aim(lanes, pair, towards); left != 0; left &= left - 1) {
        const auto lane = static_cast<std::size_t>(std::countr_zero(left));
        Ray& ray = shadow.rays[shadow.count];
        Rgb& arriving = shadow.arriving[shadow.count];
        ray = {.origin = towards.origin.get(lane),
               .direction = towards.direction.get(lane),
               .near_m = 0.0f,
               .far_m = towards.far_m[lane]};
        arriving = towards.weight[lane] * light.strength;
        finish(light, points[lane], ray, arriving);
        if (arriving != Rgb(0.0f))
            shadow.points[shadow.count++] = static_cast<std::uint8_t>(lane);
    }
    if (light.casts_shadow)
        scene_.shadow_transmittances(std::span(shadow.rays).first(shadow.count), shadow.passing);
    else
        shadow.passing.fill(Rgb(1.0f));
    for (std::size_t index = 0; index < shadow.count; ++index) {
        Irradiance& sum = irradiance[shadow.points[index]];
        sum.unshadowed += shadow.arriving[index];
        if (shadow.passing[index] == Rgb(0.0f))
            continue;
        if (has_media_)
            shadow.passing[index] *= media_.transmittance(shadow.rays[index]);
        sum.from_lights += shadow.arriving[index] * shadow.passing[index];
    }
}

/// Light from infinitely far away. One ray at a time: in packets, rays into all directions are slower.
Rgb DirectLight::past_everything(const Ray& ray) const {
    const Rgb through_surfaces = scene_.shadow_transmittance(ray);
    if (!has_media_ || through_surfaces == Rgb(0.0f))
        return through_surfaces;
    return through_surfaces * media_.transmittance(ray);
}

Rgb DirectLight::world_irradiance(const SurfacePoint& point, const PairIndex& pair) const {
    const World& world = scene_.world();
    const vec3& normal = point.shading.shading_normal;
    const auto power_share = [](float a, float b) { return a * a / (a * a + b * b); };

    const vec3 around_normal =
        sample_cosine_hemisphere(pixel_pair(point.pixel_seed, pair.sample_index, pair.pair_index));
    const vec3 direction = from_frame(normal, around_normal);
    float share = 1.0f;
    if (world.has_image())
        share = power_share(cosine_hemisphere_pdf_per_sr(around_normal.z), world.pdf_per_sr(direction));
    Rgb sum(0.0f);
    if (around_normal.z > 0.0f && share > 0.0f)
        sum = pi * share * world.radiance(direction) *
              past_everything({.origin = point.spawn.towards(direction), .direction = direction});
    if (!world.has_image())
        return sum;

    const World::DirectionSample sample =
        world.sample(pixel_pair(point.pixel_seed, pair.sample_index, pair.pair_index + 1));
    const float cosine = glm::dot(normal, sample.direction);
    if (cosine <= 0.0f || sample.pdf_per_sr <= 0.0f)
        return sum;
    const float weight =
        power_share(sample.pdf_per_sr, cosine_hemisphere_pdf_per_sr(cosine)) * cosine / sample.pdf_per_sr;
    return sum + weight * sample.radiance * past_everything(shadow_ray(point, sample.direction));
}
} // namespace tyndall::render
