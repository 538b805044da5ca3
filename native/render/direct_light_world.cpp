// SPDX-License-Identifier: GPL-3.0-or-later
// The world's part of direct_light.hpp: by the cosine, by the image, and by lobes' own directions, one of them by chance.
// Each meets what Cycles' rays of that strategy meet: those by the image are shadow rays, the others diffuse or glossy.
#include "core/sampling.hpp"
#include "render/direct_light.hpp"
#include "render/shadow_rays.hpp"
#include "render/surface_directions.hpp"
#include <algorithm>
#include <bit>
#include <cmath>

namespace tyndall::render {
/// Of directions, that the image has where there is one: as many as what reflects them.
static constexpr float image_share = 0.5f;

float DirectLight::share_below_surface(const SurfacePoint& point, const vec3& direction, float image_pdf_per_sr,
                                       float own_pdf_per_sr) const {
    if (!point.is_below_surface(direction) || scene_.is_cube(point.hit))
        return 1.0f;
    return scene_.world().has_image() ? power_share(image_pdf_per_sr, own_pdf_per_sr) : 0.0f;
}

void DirectLight::aim_by_strategies(const SurfacePoint& point, const LobeSet& lobes, vec2 u, float share,
                                    std::size_t index, ShadowRays& shadow) const {
    const World& world = scene_.world();
    const SurfaceDirections own(point, lobes);
    const float p_image = world.has_image() ? image_share : 0.0f;
    const bool by_image = u.x < p_image;
    const vec2 within{by_image ? even_within(u.x, 0.0f, p_image) : even_within(u.x, p_image, 1.0f - p_image), u.y};
    const bool by_lobes = !by_image && own.is_by_lobes(within);
    vec3 direction;
    World::Look look{};
    if (by_image) {
        const World::DirectionSample sample = world.sample(within);
        direction = sample.direction;
        look = {sample.radiance, sample.pdf_per_sr};
    } else
        direction = own.sample(within);
    const float cosine = counted_cosine(point, lobes, direction);
    const bool is_behind = cosine == LobeSet::least_cosine;
    // As in Cycles, where shadow rays that leave a smooth surface against its normal begin inside.
    if (cosine == 0.0f || (by_image && is_behind))
        return;
    if (!by_image)
        look = world.look(direction);
    const float own_pdf_per_sr = own.pdf_per_sr(direction);
    float density = own_pdf_per_sr;
    if (world.has_image()) {
        const float by_surface = (1.0f - p_image) * own_pdf_per_sr, of_image = p_image * look.pdf_per_sr;
        density = by_surface + of_image;
        // Where these meet other things, each gives what it gives in Cycles, which weighs by squares.
        if (scene_.tells_rays_apart() || is_behind)
            density = by_image ? of_image / power_share(look.pdf_per_sr, own_pdf_per_sr)
                               : by_surface / power_share(own_pdf_per_sr, look.pdf_per_sr);
    }
    if (!(density > 0.0f) || !std::isfinite(density))
        return;
    const float counted = share_below_surface(point, direction, look.pdf_per_sr, own_pdf_per_sr);
    const Rgb arriving = look.radiance * (counted * share * cosine / density);
    if (arriving == Rgb(0.0f))
        return;
    const bool is_lifted = by_image || by_lobes;
    const Ray ray = is_lifted ? shadow_ray(point, direction) : point.ray_towards(direction);
    const RayKind kind = by_image ? RayKind::Shadow : by_lobes || own.is_gloss() ? RayKind::Glossy : RayKind::Diffuse;
    Rgb per_irradiance = lobes.lobes.empty() ? Rgb(0.0f) : lobes.per_irradiance(direction);
    if (lobes.draws_on_both_sides()) {
        const float drawn = world.has_image() ? power_share(lobes.pdf_per_sr(direction), look.pdf_per_sr) : 1.0f;
        per_irradiance = glm::mix(per_irradiance, lobes.per_irradiance_as_drawn(direction), drawn);
    }
    shadow.push(ray, arriving, index, arriving * per_irradiance, kind);
}

void DirectLight::aim_at_world(const LitSurface& surface, const PairIndex& pair, float share,
                               ShadowRays& shadow) const {
    const World& world = scene_.world();
    // Around a world of one radiance, points without such lobes are aimed side by side.
    LaneSet alone = surface.lanes.present;
    if (!world.has_image())
        for (std::size_t index = 0; index < surface.points.size(); ++index)
            if (surface.lobes == nullptr || !(*surface.lobes)[index].has_directions())
                alone &= ~(LaneSet{1} << index);
    if (const LaneSet together = surface.lanes.present & ~alone; together != 0) {
        AimedRays towards;
        for (LaneSet left = LightAim::aim_at_world(surface.lanes, pair, towards) & together; left != 0;
             left &= left - 1) {
            const auto lane = static_cast<std::size_t>(std::countr_zero(left));
            Ray ray = ray_of(towards, lane);
            ray.passed_count = surface.points[lane].passed_count;
            if (share_below_surface(surface.points[lane], ray.direction, 0.0f, 1.0f) == 0.0f)
                continue;
            const Rgb arriving = pi * share * world.radiance(ray.direction);
            shadow.push(ray, arriving, lane,
                        surface.lobes == nullptr || (*surface.lobes)[lane].lobes.empty()
                            ? Rgb(0.0f)
                            : arriving * (*surface.lobes)[lane].per_irradiance(ray.direction),
                        RayKind::Diffuse);
        }
    }
    if (alone == 0)
        return;
    std::array<std::uint32_t, most_points> seeds{};
    std::array<vec2, most_points> u;
    for (std::size_t index = 0; index < surface.points.size(); ++index)
        seeds[index] = surface.points[index].pixel_seed;
    pixel_pairs(seeds, pair.sample_index, pair.pair_index, u);
    for (LaneSet left = alone; left != 0; left &= left - 1) {
        const auto index = static_cast<std::size_t>(std::countr_zero(left));
        aim_by_strategies(surface.points[index], surface.lobes != nullptr ? (*surface.lobes)[index] : LobeSet{},
                          u[index], share, index, shadow);
    }
}

void DirectLight::add_world(const LitSurface& surface, const PairIndex& pair, float share,
                            std::span<Irradiance> irradiance) const {
    ShadowRays shadow;
    aim_at_world(surface, pair, share, shadow);
    add_from_world(shadow, surface.among, irradiance);
}

/// One ray at a time: in packets, rays into all directions are slower.
void DirectLight::add_from_world(ShadowRays& shadow, Among among, std::span<Irradiance> irradiance) const {
    for (std::size_t index = 0; index < shadow.count; ++index) {
        Ray within_reach = shadow.rays[index]; // media dim the light all the way
        within_reach.far_m = std::min(within_reach.far_m, world_reach_m_);
        shadow.passing[index] = scene_.shadow_transmittance(within_reach, among, shadow.kinds[index]);
    }
    if (has_media_ && among == Among::All)
        media_.attenuate(shadow.all(), shadow.passing);
    for (std::size_t index = 0; index < shadow.count; ++index) {
        irradiance[shadow.points[index]].from_world += shadow.arriving[index] * shadow.passing[index];
        irradiance[shadow.points[index]].reflected += shadow.reflected[index] * shadow.passing[index];
    }
}
} // namespace tyndall::render
