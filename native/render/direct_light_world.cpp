// SPDX-License-Identifier: GPL-3.0-or-later
// The world's part of direct_light.hpp: by the cosine, by the image, and by lobes' own directions.
#include "core/sampling.hpp"
#include "render/direct_light.hpp"
#include "render/shadow_rays.hpp"
#include <bit>
#include <cmath>
#include <numbers>

namespace tyndall::render {
static constexpr float pi = std::numbers::pi_v<float>;

Rgb DirectLight::reflected_of_world(const LobeSet& lobes, const vec3& direction, const Rgb& radiance, float cosine,
                                    float own_pdf_per_sr) const {
    const float by_cosine = cosine_hemisphere_pdf_per_sr(cosine),
                by_image = scene_.world().has_image() ? scene_.world().pdf_per_sr(direction) : 0.0f,
                by_lobes = lobes.pdf_per_sr(direction);
    const float all2 = by_cosine * by_cosine + by_image * by_image + by_lobes * by_lobes;
    if (!(all2 > 0.0f) || !std::isfinite(all2))
        return Rgb(0.0f);
    return radiance * lobes.per_irradiance(direction) * (cosine * (own_pdf_per_sr / all2));
}

void DirectLight::aim_at_world(const LitSurface& surface, const PairIndex& pair, float share,
                               ShadowRays& shadow) const {
    const World& world = scene_.world();
    AimedRays towards;
    for (LaneSet left = LightAim::aim_at_world(surface.lanes, pair, towards); left != 0; left &= left - 1) {
        const auto lane = static_cast<std::size_t>(std::countr_zero(left));
        const Ray ray = ray_of(towards, lane);
        const float cosine = towards.weight[lane];
        const float weight = world.has_image()
                                 ? power_share(cosine_hemisphere_pdf_per_sr(cosine), world.pdf_per_sr(ray.direction))
                                 : 1.0f;
        if (!(weight > 0.0f))
            continue;
        const Rgb radiance = world.radiance(ray.direction);
        shadow.push(ray, pi * share * weight * radiance, lane);
        if (surface.lobes != nullptr && !(*surface.lobes)[lane].lobes.empty())
            shadow.reflected[shadow.count - 1] = reflected_of_world(
                (*surface.lobes)[lane], ray.direction, share * radiance, cosine, cosine_hemisphere_pdf_per_sr(cosine));
    }
}

void DirectLight::aim_at_world_image(const LitSurface& surface, const PairIndex& pair, float share,
                                     ShadowRays& shadow) const {
    const World& world = scene_.world();
    for (std::size_t index = 0; index < surface.points.size(); ++index) {
        const SurfacePoint& point = surface.points[index];
        const World::DirectionSample sample =
            world.sample(pixel_pair(point.pixel_seed, pair.sample_index, pair.pair_index + 1));
        const float cosine = glm::dot(point.shading.shading_normal, sample.direction);
        if (cosine <= 0.0f || sample.pdf_per_sr <= 0.0f)
            continue;
        const float weight =
            power_share(sample.pdf_per_sr, cosine_hemisphere_pdf_per_sr(cosine)) * cosine / sample.pdf_per_sr;
        shadow.push(shadow_ray(point, sample.direction), share * weight * sample.radiance, index);
        if (surface.lobes != nullptr && !(*surface.lobes)[index].lobes.empty())
            shadow.reflected[shadow.count - 1] = reflected_of_world((*surface.lobes)[index], sample.direction,
                                                                    share * sample.radiance, cosine, sample.pdf_per_sr);
    }
}

void DirectLight::aim_at_world_lobes(const LitSurface& surface, const PairIndex& pair, float share,
                                     ShadowRays& shadow) const {
    for (std::size_t index = 0; index < surface.points.size(); ++index) {
        const LobeSet& lobes = (*surface.lobes)[index];
        const SurfacePoint& point = surface.points[index];
        if (!lobes.has_directions())
            continue;
        const vec3 direction = lobes.sample(pixel_pair(point.pixel_seed, pair.sample_index, pair.pair_index + 2));
        const float cosine = glm::dot(point.shading.shading_normal, direction);
        if (!(cosine > 0.0f)) // nor what is no direction
            continue;
        const Rgb reflected = reflected_of_world(lobes, direction, share * scene_.world().radiance(direction), cosine,
                                                 lobes.pdf_per_sr(direction));
        if (reflected != Rgb(0.0f))
            shadow.push(shadow_ray(point, direction), Rgb(0.0f), index, reflected);
    }
}

void DirectLight::add_world(const LitSurface& surface, const PairIndex& pair, float share,
                            std::span<Irradiance> irradiance) const {
    ShadowRays shadow;
    aim_at_world(surface, pair, share, shadow);
    add_from_world(shadow, irradiance);
    if (scene_.world().has_image()) {
        shadow.count = 0;
        aim_at_world_image(surface, pair, share, shadow);
        add_from_world(shadow, irradiance);
    }
    if (surface.lobes != nullptr) {
        shadow.count = 0;
        aim_at_world_lobes(surface, pair, share, shadow);
        add_from_world(shadow, irradiance);
    }
}

/// One ray at a time: in packets, rays into all directions are slower.
void DirectLight::add_from_world(ShadowRays& shadow, std::span<Irradiance> irradiance) const {
    for (std::size_t index = 0; index < shadow.count; ++index) {
        Ray within_reach = shadow.rays[index]; // media dim the light all the way
        within_reach.far_m = std::min(within_reach.far_m, world_reach_m_);
        shadow.passing[index] = scene_.shadow_transmittance(within_reach);
    }
    if (has_media_)
        media_.attenuate(shadow.all(), shadow.passing);
    for (std::size_t index = 0; index < shadow.count; ++index) {
        irradiance[shadow.points[index]].from_world += shadow.arriving[index] * shadow.passing[index];
        irradiance[shadow.points[index]].reflected += shadow.reflected[index] * shadow.passing[index];
    }
}
} // namespace tyndall::render
