// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/direct_light.hpp"
#include "core/sampling.hpp"
#include "render/shadow_terminator.hpp"
#include "shading/surface_program.hpp"
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
        lights_.push_back(index);
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
    Ray ray = scene_.leaving_ray(point.hit, direction);
    ray.origin += terminator_lift(scene_, point.hit, point.shading, direction);
    return ray;
}

Rgb DirectLight::passing_light(const Ray& ray, bool casts_shadow) const {
    const Rgb through_surfaces = casts_shadow ? scene_.shadow_transmittance(ray) : Rgb(1.0f);
    if (!has_media_ || through_surfaces == Rgb(0.0f))
        return through_surfaces;
    return through_surfaces * media_.transmittance(ray);
}

DirectLight::Irradiance DirectLight::at(const SurfacePoint& point, PixelSamples& samples) const {
    Irradiance result;
    for (const std::uint32_t index : lights_) {
        const LightSample light =
            sample_light_towards(scene_.lights()[index], index, samples.next_pair(), point.shading.position);
        vec3 direction = light.towards_light;
        Rgb strength = light.strength;
        if (!light.is_directional) {
            const vec3 to_light = light.position - point.shading.position;
            const float distance_m = glm::length(to_light);
            if (!(distance_m > 0.0f))
                continue; // The light stands on the surface: it has no direction.
            direction = to_light / distance_m;
            strength = intensity_w_per_sr(light, -direction) / (distance_m * distance_m + light.softening_m2);
        }
        const float cosine = glm::dot(point.shading.shading_normal, direction);
        if (cosine <= 0.0f || strength == Rgb(0.0f))
            continue;
        Ray ray = shadow_ray(point, direction);
        if (!light.is_directional) {
            const vec3 to_light = light.position - ray.origin; // The lift may have turned it.
            ray.far_m = glm::length(to_light);
            ray.direction = to_light / ray.far_m;
        }
        result.unshadowed += cosine * strength;
        result.from_lights += cosine * strength * passing_light(ray, light.casts_shadow);
    }
    if (has_world_light_)
        result.from_world = world_irradiance(point, samples);
    return result;
}

Rgb DirectLight::world_irradiance(const SurfacePoint& point, PixelSamples& samples) const {
    const World& world = scene_.world();
    const vec3& normal = point.shading.shading_normal;
    const auto power_share = [](float a, float b) { return a * a / (a * a + b * b); };

    const vec3 around_normal = sample_cosine_hemisphere(samples.next_pair());
    const vec3 direction = from_frame(normal, around_normal);
    float share = 1.0f;
    if (world.has_image())
        share = power_share(cosine_hemisphere_pdf_per_sr(around_normal.z), world.pdf_per_sr(direction));
    Rgb sum(0.0f);
    if (around_normal.z > 0.0f && share > 0.0f)
        sum = pi * share * world.radiance(direction) * passing_light(scene_.leaving_ray(point.hit, direction), true);
    if (!world.has_image())
        return sum;

    const World::DirectionSample sample = world.sample(samples.next_pair());
    const float cosine = glm::dot(normal, sample.direction);
    if (cosine <= 0.0f || sample.pdf_per_sr <= 0.0f)
        return sum;
    const float weight =
        power_share(sample.pdf_per_sr, cosine_hemisphere_pdf_per_sr(cosine)) * cosine / sample.pdf_per_sr;
    return sum + weight * sample.radiance * passing_light(shadow_ray(point, sample.direction), true);
}
} // namespace tyndall::render
