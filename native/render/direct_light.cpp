// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/direct_light.hpp"
#include "core/sampling.hpp"
#include "render/shadow_terminator.hpp"
#include "shading/surface_program.hpp"
#include <algorithm>
#include <array>
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
        lights_.push_back({index, LightReach(light)});
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

void DirectLight::at(std::span<const SurfacePoint> points, const PairRange& pairs,
                     std::span<Irradiance> irradiance) const {
    std::fill_n(irradiance.begin(), points.size(), Irradiance{});
    // A light has the same pair wherever it shines: what one point skips does not shift another light's numbers.
    PairRange pair = pairs;
    for (const ReachingLight& light : lights_) {
        add_light(light, points, pair, irradiance);
        ++pair.first_pair;
    }
    if (has_world_light_)
        for (std::size_t index = 0; index < points.size(); ++index)
            irradiance[index].from_world = world_irradiance(points[index], pair);
}

/// Rays of several points towards one light.
struct DirectLight::ShadowRays {
    std::array<Ray, most_points> rays;
    std::array<Rgb, most_points> arriving; ///< With nothing between, times the cosine.
    std::array<Rgb, most_points> passing;
    std::array<std::uint8_t, most_points> points;
    std::size_t count = 0;
};

void DirectLight::add_light(const ReachingLight& reaching, std::span<const SurfacePoint> points, const PairRange& pair,
                            std::span<Irradiance> irradiance) const {
    const Light& light = scene_.lights()[reaching.index];
    std::array<std::uint8_t, most_points> reached;
    std::array<std::uint32_t, most_points> seeds;
    std::size_t reached_count = 0;
    for (std::size_t index = 0; index < points.size(); ++index)
        if (reaching.reach.may_light(points[index].shading.position, points[index].shading.shading_normal)) {
            reached[reached_count] = static_cast<std::uint8_t>(index);
            seeds[reached_count++] = points[index].pixel_seed;
        }
    if (reached_count == 0)
        return;
    std::array<vec2, most_points> u{};
    if (light.radius_m > 0.0f || light.half_angle_rad > 0.0f)
        pixel_pairs(std::span(seeds).first(reached_count), pair.sample_index, pair.first_pair, u);

    ShadowRays shadow;
    for (std::size_t index = 0; index < reached_count; ++index)
        if (aim(points[reached[index]], reaching.index, u[index], shadow.rays[shadow.count],
                shadow.arriving[shadow.count]))
            shadow.points[shadow.count++] = reached[index];
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

bool DirectLight::aim(const SurfacePoint& point, std::uint32_t light_index, vec2 u, Ray& ray, Rgb& arriving) const {
    const vec3& position = point.shading.position;
    const LightSample light = sample_light_towards(scene_.lights()[light_index], light_index, u, position);
    vec3 direction = light.towards_light;
    Rgb strength = light.strength;
    if (!light.is_directional) {
        const vec3 to_light = light.position - position;
        const float distance_m = glm::length(to_light);
        if (!(distance_m > 0.0f))
            return false; // The light stands on the surface: it has no direction.
        direction = to_light / distance_m;
        strength = intensity_w_per_sr(light, -direction) / (distance_m * distance_m + light.softening_m2);
    }
    const float cosine = glm::dot(point.shading.shading_normal, direction);
    if (cosine <= 0.0f || strength == Rgb(0.0f))
        return false;
    ray = shadow_ray(point, direction);
    if (!light.is_directional) {
        const vec3 to_light = light.position - ray.origin; // The lift may have turned it.
        ray.far_m = glm::length(to_light);
        ray.direction = to_light / ray.far_m;
    }
    arriving = cosine * strength;
    return true;
}

/// Light from infinitely far away. One ray at a time: in packets, rays into all directions are slower.
Rgb DirectLight::past_everything(const Ray& ray) const {
    const Rgb through_surfaces = scene_.shadow_transmittance(ray);
    if (!has_media_ || through_surfaces == Rgb(0.0f))
        return through_surfaces;
    return through_surfaces * media_.transmittance(ray);
}

Rgb DirectLight::world_irradiance(const SurfacePoint& point, const PairRange& pairs) const {
    const World& world = scene_.world();
    const vec3& normal = point.shading.shading_normal;
    const auto power_share = [](float a, float b) { return a * a / (a * a + b * b); };

    const vec3 around_normal =
        sample_cosine_hemisphere(pixel_pair(point.pixel_seed, pairs.sample_index, pairs.first_pair));
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
        world.sample(pixel_pair(point.pixel_seed, pairs.sample_index, pairs.first_pair + 1));
    const float cosine = glm::dot(normal, sample.direction);
    if (cosine <= 0.0f || sample.pdf_per_sr <= 0.0f)
        return sum;
    const float weight =
        power_share(sample.pdf_per_sr, cosine_hemisphere_pdf_per_sr(cosine)) * cosine / sample.pdf_per_sr;
    return sum + weight * sample.radiance * past_everything(shadow_ray(point, sample.direction));
}
} // namespace tyndall::render
