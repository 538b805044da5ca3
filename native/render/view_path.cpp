// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/view_path.hpp"
#include <cmath>
#include <numbers>

namespace tyndall::render {
// Random pairs set aside for the light of one layer: 2 for each of 100 lights and 2 of the world fit; beyond, layers
// share pairs, which adds noise but no bias.
static constexpr std::uint32_t pairs_per_layer = 256;
// Blender's default: a surface that covers less does not show in Depth, Normal and Position.
static constexpr float alpha_threshold = 0.5f;

static float average(const Rgb& value) { return (value.x + value.y + value.z) * (1.0f / 3.0f); }

PathSample ViewPath::follow(const Ray& camera_ray, PixelSamples& samples, std::vector<MediumPart>& parts) const {
    PathSample result;
    const bool has_media = !media_.is_empty();
    Rgb through_surfaces(1.0f), through_media(1.0f);
    bool has_first_surface = false;
    Ray part = camera_ray;
    for (std::uint32_t layer = 0; layer < max_layer_count; ++layer) {
        const Hit hit = scene_.closest_hit(part);
        if (has_media) {
            Ray inside = part;
            if (hit.is_hit())
                inside.far_m = hit.distance_m;
            const Rgb in_front = through_surfaces * through_media;
            if (config_.collects_parts)
                parts.push_back({.near_m = inside.near_m, .far_m = inside.far_m, .weight = in_front});
            result.radiance += in_front * media_.emission(inside);
            through_media *= media_.transmittance(inside);
            if (!has_first_surface)
                result.transmittance = through_media;
        }
        const Rgb throughput = through_surfaces * through_media;
        if (!hit.is_hit()) {
            if (config_.is_film_transparent)
                result.alpha = 1.0f - average(throughput);
            else
                result.radiance += throughput * scene_.world().radiance(camera_ray.direction);
            return result;
        }
        const SurfacePoint point{.hit = hit, .shading = scene_.shading_point(part, hit)};
        const SurfaceClosures closures = scene_.closures(part, hit);
        if (!has_first_surface && 1.0f - average(closures.transparent) >= alpha_threshold) {
            has_first_surface = true;
            result.depth_m = glm::dot(point.shading.position - camera_.position(), camera_.forward());
            result.normal = point.shading.shading_normal;
            result.position = point.shading.position;
        }
        const bool is_black = closures.diffuse_albedo == Rgb(0.0f);
        if (!is_black || config_.lights_black_surfaces) {
            samples.jump_to(1 + layer * pairs_per_layer);
            const DirectLight::Irradiance irradiance = light_.at(point, samples);
            result.radiance += throughput * closures.diffuse_albedo * std::numbers::inv_pi_v<float> * irradiance.sum();
            result.lit += throughput * irradiance.from_lights;
            result.unshadowed += throughput * irradiance.unshadowed;
        }
        result.radiance += throughput * closures.emission;
        result.emission += throughput * closures.emission;
        result.diffuse_colour += throughput * closures.diffuse_albedo;
        through_surfaces *= closures.transparent;
        if (through_surfaces == Rgb(0.0f))
            return result;
        // The same ray meets the same triangle at the same distance, bit for bit: one step further is behind it.
        part.near_m = std::nextafter(hit.distance_m * (1.0f + 4e-7f), camera_ray.far_m);
    }
    return result;
}
} // namespace tyndall::render
