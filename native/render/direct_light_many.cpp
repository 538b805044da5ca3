// SPDX-License-Identifier: GPL-3.0-or-later
// The parts of direct_light.hpp of emitters that light some shaders alone, and of lights that are drawn, not asked each:
// by the tree, of what glows by the cosine and by lobes' own directions, too, and of lamps with a size by those of sharp
// lobes.
// Based on: Veach, dissertation, Stanford 1997, section 9.2 (power heuristic): a wide plate nearby is met by chance.
#include "core/sampling.hpp"
#include "render/direct_light.hpp"
#include "render/light_groups.hpp"
#include "render/lobes_of_kinds.hpp"
#include "render/passed_surface.hpp"
#include "render/shadow_rays.hpp"
#include <algorithm>

namespace tyndall::render {
static constexpr std::uint32_t place_pairs = 0x0800'0000, lobe_pairs = 0x1000'0000,
                               cosine_pairs = 0x1800'0000; // far behind those of strata
/// Surfaces that let light through, on a lobe's ray.
static constexpr int most_surfaces_passed = 16;

/// What stands in a ray's way may be no blocker of what it would have met: such emitters are aimed at alone.
static bool is_met_by_chance(const ManyLights::Aimed& glow) {
    return glow.links == nullptr || glow.links->is_blocked_by_all() || !(glow.pdf_per_sr > 0.0f);
}

void DirectLight::aim_at_many(const LitSurface& surface, const PairIndex& pair, float share, ShadowRays& shadow) const {
    for (std::size_t index = 0; index < surface.points.size(); ++index) {
        const SurfacePoint& point = surface.points[index];
        const float choice = pixel_pair(point.pixel_seed, pair.sample_index, pair.pair_index).x;
        const vec2 place = pixel_pair(point.pixel_seed, pair.sample_index, place_pairs + pair.pair_index);
        const LobeSet* lobes = surface.lobes != nullptr ? &(*surface.lobes)[index] : nullptr;
        std::optional<ManyLights::Aimed> aimed =
            many_->aim(point, choice, place, lobes != nullptr && finds_lamps(*lobes));
        if (!aimed || (aimed->links != nullptr && !may_light(*aimed->links, point)))
            continue;
        if (surface.among == Among::Catchers &&
            !(aimed->lamp != nullptr ? aimed->lamp->lights_catchers : scene_.is_shadow_catcher(aimed->instance)))
            continue;
        const bool is_met = aimed->lamp == nullptr && is_met_by_chance(*aimed);
        const vec3 towards = aimed->ray.direction; // before a smooth surface's terminator lifts the ray
        if (aimed->lamp != nullptr)
            finish(*aimed->lamp, point, aimed->ray, aimed->arriving);
        else
            lift(point, aimed->ray);
        const Rgb arriving = share * aimed->arriving;
        if (arriving == Rgb(0.0f))
            continue;
        const bool is_a_point =
            aimed->lamp != nullptr && aimed->lamp->kind != LightKind::Area && !(aimed->lamp->radius_m > 0.0f);
        Rgb reflected(0.0f);
        if (lobes != nullptr && !lobes->lobes.empty()) {
            float weight = 1.0f;
            if (aimed->pdf_per_sr > 0.0f && (is_met || aimed->lamp != nullptr) && lobes->has_directions())
                weight = power_share(aimed->pdf_per_sr, lobes->pdf_per_sr(towards));
            thread_local std::vector<Lobe> room;
            const LobeSet lit = lobes_of_kinds(aimed->kinds, *lobes, room);
            reflected =
                arriving * (is_a_point ? lit.per_irradiance_of_point(towards) : lit.per_irradiance(towards)) * weight;
        }
        shadow.push(aimed->ray, aimed->kinds.diffuse ? arriving : Rgb(0.0f), index, reflected);
        const float cosine = glm::dot(point.shading.shading_normal, towards);
        shadow.shares[shadow.count - 1] =
            is_met ? power_share(aimed->pdf_per_sr, cosine_hemisphere_pdf_per_sr(cosine)) : 1.0f;
        shadow.lamps[shadow.count - 1] = aimed->lamp;
        shadow.groups[shadow.count - 1] = aimed->light_group;
        shadow.links[shadow.count - 1] = aimed->links;
    }
}

/// One ray at a time: they go to different lights.
void DirectLight::add_many(const LitSurface& surface, const PairIndex& pair, float share,
                           std::span<Irradiance> irradiance, std::span<Irradiance> by_group) const {
    ShadowRays shadow;
    aim_at_many(surface, pair, share, shadow);
    for (std::size_t index = 0; index < shadow.count; ++index) {
        const auto ray = shadow.all().subspan(index, 1);
        const auto passing = std::span(shadow.passing).subspan(index, 1);
        const Light* const lamp = shadow.lamps[index];
        if (lamp != nullptr && !lamp->casts_shadow)
            passing[0] = Rgb(1.0f);
        else if (shadow.links[index] == nullptr)
            passing[0] = scene_.shadow_transmittance(ray[0], surface.among);
        else
            scene_.shadow_transmittances(ray, passing, *shadow.links[index], surface.among);
        if (has_media_ && surface.among == Among::All && (lamp == nullptr || lamp->is_dimmed_by_media()))
            media_.attenuate(ray, passing);
        Irradiance found;
        found.unshadowed = shadow.arriving[index];
        found.from_lights = shadow.arriving[index] * shadow.passing[index] * shadow.shares[index];
        found.reflected = shadow.reflected[index] * shadow.passing[index];
        irradiance[shadow.points[index]] += found;
        add_to_group(by_group, shadow.groups[index], surface.points.size(), shadow.points[index], found);
    }
    thread_local std::vector<Rgb> of_groups;
    of_groups.resize(by_group.empty() ? 0 : by_group.size() / surface.points.size());
    for (std::size_t index = 0; many_->has_glow() && index < surface.points.size(); ++index) {
        const SurfacePoint& point = surface.points[index];
        const vec2 u = pixel_pair(point.pixel_seed, pair.sample_index, cosine_pairs + pair.pair_index);
        const vec3 direction = from_frame(point.shading.shading_normal, sample_cosine_hemisphere(u));
        const float cosine = glm::dot(point.shading.shading_normal, direction);
        irradiance[index].from_lights +=
            share * of_glow(point, {direction, cosine, cosine_hemisphere_pdf_per_sr(cosine)}, nullptr, surface.among,
                            of_groups);
        for (std::size_t group = 0; group < of_groups.size(); ++group)
            by_group[group * surface.points.size() + index].from_lights += share * of_groups[group];
    }
    for (std::size_t index = 0; surface.lobes != nullptr && index < surface.points.size(); ++index) {
        const SurfacePoint& point = surface.points[index];
        const LobeSet& lobes = (*surface.lobes)[index];
        const bool may_find_lamps = finds_lamps(lobes);
        if (!may_find_lamps && !(many_->has_glow() && lobes.has_directions()))
            continue;
        const std::optional<DrawnDirection> drawn = draw_by_lobes(point, lobes, pair);
        if (!drawn)
            continue;
        if (many_->has_glow()) {
            irradiance[index].reflected += share * of_glow(point, *drawn, &lobes, surface.among, of_groups);
            for (std::size_t group = 0; group < of_groups.size(); ++group)
                by_group[group * surface.points.size() + index].reflected += share * of_groups[group];
        }
        if (!may_find_lamps)
            continue;
        thread_local std::vector<RayToLamp> rays;
        rays.clear();
        aim_at_lamps_met(point, lobes, *drawn, share, surface.among, rays);
        std::ranges::stable_sort(rays, {}, [](const RayToLamp& to_lamp) { return to_lamp.ray.far_m; });
        const Ray* blocked = nullptr; // and all that lies behind along it
        for (const RayToLamp& to_lamp : rays) {
            const Ray& ray = to_lamp.ray;
            std::array<Rgb, 1> passing{Rgb(1.0f)};
            if (to_lamp.lamp->casts_shadow) {
                if (blocked != nullptr && blocked->origin == ray.origin && blocked->direction == ray.direction)
                    continue;
                passing[0] = scene_.shadow_transmittance(ray, surface.among);
                blocked = passing[0] == Rgb(0.0f) ? &ray : nullptr;
            }
            if (has_media_ && surface.among == Among::All && to_lamp.lamp->is_dimmed_by_media())
                media_.attenuate({&ray, 1}, passing);
            const Irradiance found{.reflected = to_lamp.reflected * passing[0]};
            irradiance[index] += found;
            add_to_group(by_group, to_lamp.lamp->light_group, surface.points.size(), index, found);
        }
    }
}

void DirectLight::add_rays(std::size_t light, const RayCount& count, const LitSurface& surface,
                           const PairIndex& first_pair, std::span<Irradiance> irradiance,
                           std::span<Irradiance> many_by_group) const {
    const float share = static_cast<float>(count.turn) / static_cast<float>(count.rays);
    for (std::uint32_t ray = 0; ray < count.rays; ++ray) {
        const PairIndex pair = pair_of(light, ray, count, first_pair);
        if (is_world(light))
            add_world(surface, pair, share, irradiance);
        else if (is_many(light))
            add_many(surface, pair, share, irradiance, many_by_group);
        else
            add_light(lights_[light], surface, pair, share, irradiance);
    }
}

void DirectLight::add_by_kinds(std::size_t light, const LitKinds& kinds, const RayCount& count,
                               const LitSurface& surface, const PairIndex& first_pair,
                               std::span<Irradiance> irradiance) const {
    thread_local std::array<std::vector<Lobe>, most_points> rooms;
    PointLobes lobes;
    MostPdfs most_pdfs;
    most_pdfs.fill(-1.0f);
    for (std::size_t point = 0; surface.lobes != nullptr && point < surface.points.size(); ++point)
        lobes[point] = lobes_of_kinds(kinds, (*surface.lobes)[point], rooms[point]);
    std::array<Irradiance, most_points> found;
    add_rays(light, count,
             {surface.points, surface.lanes, surface.lobes != nullptr ? &lobes : nullptr, surface.among, &most_pdfs},
             first_pair, found, {});
    for (std::size_t point = 0; point < surface.points.size(); ++point) {
        if (!kinds.diffuse)
            found[point].from_lights = found[point].unshadowed = found[point].from_world = Rgb(0.0f);
        irradiance[point] += found[point];
    }
}

bool DirectLight::finds_lamps(const LobeSet& lobes) const {
    return many_->has_wide_lamps() && lobes.has_directions() && are_sharp(lobes);
}

std::optional<DirectLight::DrawnDirection> DirectLight::draw_by_lobes(const SurfacePoint& point, const LobeSet& lobes,
                                                                      const PairIndex& pair) {
    const vec3 direction = lobes.sample(pixel_pair(point.pixel_seed, pair.sample_index, lobe_pairs + pair.pair_index));
    const float cosine = glm::dot(point.shading.shading_normal, direction);
    const float pdf_per_sr = cosine > 0.0f ? lobes.pdf_per_sr(direction) : 0.0f;
    if (!(pdf_per_sr > 0.0f))
        return std::nullopt;
    return DrawnDirection{direction, cosine, pdf_per_sr};
}

void DirectLight::aim_at_lamps_met(const SurfacePoint& point, const LobeSet& lobes, const DrawnDirection& drawn,
                                   float share, Among among, std::vector<RayToLamp>& rays) const {
    thread_local std::vector<ManyLights::LampMet> met;
    many_->meet_lamps({.origin = point.shading.position, .direction = drawn.direction}, met);
    for (const ManyLights::LampMet& lamp : met) {
        const Light& light = scene_.lights()[many_->lamps()[lamp.number]];
        if (among == Among::Catchers && !light.lights_catchers)
            continue;
        Ray ray{.origin = point.spawn.towards(drawn.direction), .direction = drawn.direction, .far_m = lamp.hit.far_m};
        const float weight =
            power_share(drawn.pdf_per_sr, many_->pdf_per_sr(point, lamp)) * drawn.cosine / drawn.pdf_per_sr;
        Rgb reflected = light.strength * (share * weight * lamp.hit.radiance_per_strength) *
                        lobes.per_irradiance_as_drawn(drawn.direction);
        finish(light, point, ray, reflected);
        if (reflected != Rgb(0.0f))
            rays.push_back({ray, reflected, &light});
    }
}

Rgb DirectLight::of_glow(const SurfacePoint& point, const DrawnDirection& drawn, const LobeSet* lobes, Among among,
                         std::span<Rgb> by_group) const {
    const auto& [direction, cosine, pdf_per_sr] = drawn;
    std::ranges::fill(by_group, Rgb(0.0f));
    Rgb sum(0.0f);
    if (!(cosine > 0.0f) || !(pdf_per_sr > 0.0f))
        return sum;
    Ray ray = shadow_ray(point, direction);
    if (!many_->may_meet_glow(ray))
        return sum;
    const auto counting = [&](const LitKinds& kinds) {
        if (lobes == nullptr)
            return Rgb(kinds.diffuse ? 1.0f : 0.0f);
        thread_local std::vector<Lobe> room;
        return lobes_of_kinds(kinds, *lobes, room).per_irradiance_as_drawn(direction);
    };
    const unsigned int mask = mask_among(among, lobes == nullptr ? bounce_mask : bounce_mask | mirror_mask);
    for (int passed = 0; passed < most_surfaces_passed; ++passed) {
        const Hit hit = scene_.closest_hit(ray, mask);
        if (!hit.is_hit())
            break;
        if (const std::optional<ManyLights::Aimed> met = many_->met(point, ray, hit);
            met && is_met_by_chance(*met) && (met->links == nullptr || may_light(*met->links, point))) {
            std::array<Rgb, 1> passing{scene_.shadow_transmittance(met->ray, among)};
            if (has_media_ && among == Among::All)
                media_.attenuate({&met->ray, 1}, passing);
            const Rgb found = met->arriving * passing[0] * counting(met->kinds) *
                              (power_share(pdf_per_sr, met->pdf_per_sr) * cosine / pdf_per_sr);
            sum += found;
            add_to_group(by_group, met->light_group, 1, 0, found);
        }
        if (scene_.transparency(ray, hit) == Rgb(0.0f))
            break;
        go_on_behind(ray, hit);
    }
    return sum;
}
} // namespace tyndall::render
