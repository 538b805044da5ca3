// SPDX-License-Identifier: GPL-3.0-or-later
// What mirrors and glass send on of a ray, and the lamps and the air that it meets there.
#include "core/random.hpp"
#include "render/follower.hpp"
#include "render/lamp_hits.hpp"
#include "render/sent_air.hpp"
#include "render/sent_rays.hpp"
#include "scene/light_texture.hpp"
#include <algorithm>

namespace tyndall::render {
// Of a mirrored ray, to be followed where nothing bends: between two panes that mirror a little, rays would double at each.
static constexpr float least_mirrored = 1.0f / 1024.0f;

void ViewPath::send_on(const Sending& sending, const SurfaceClosures& closures, std::span<const Lobe> bent,
                       std::vector<Follower>& sent) const {
    const auto& [follower, point, width_m, searches, through_media, of, gain, pixel_seed, sample_index] = sending;
    const IndirectConfig& indirect = config_.indirect;
    std::uint32_t way = 0; // which of the surface's
    const auto send = [&](const Rgb& share, const Ray& ray, RayKind kind) {
        Follower& next = sent.emplace_back(follower);
        next.part = ray;
        next.part.passed_count = follower.part.passed_count;
        next.width_m = width_m;
        next.near_m = 0.0f;
        next.through_surfaces = left_behind(next.through_surfaces, share);
        next.through_media = through_media;
        next.gain = gain;
        next.has_first_surface = true;
        next.features = searches.sent(share);
        next.of = of;
        next.kind = kind;
        next.way = hash(follower.way, way);
        next.sender = point.hit.instance;
        ++(kind == RayKind::Mirror ? next.mirror_count : next.bend_count);
        if (next.first == Scatterer::None)
            next.first = kind == RayKind::Mirror ? Scatterer::Glossy : Scatterer::Transmission;
        next.is_past = next.mirror_count > indirect.mirror_depth || next.bend_count > indirect.refraction_depth;
    };
    const Rgb in_front = follower.through_surfaces * through_media / gain;
    const vec3& own = point.shading.shading_normal;
    if (indirect.refraction_depth == 0) {
        const Rgb weight = in_front * closures.mirrored;
        if (std::max({weight.x, weight.y, weight.z}) >= least_mirrored)
            send(closures.mirrored, mirrored_ray(point, follower.part, own), RayKind::Mirror);
        return;
    }
    constexpr std::uint32_t of_ways = 0x6c69'6768; // a seed apart from those of lights
    DrawnWays ways(in_front, hash(pixel_seed, follower.way, of_ways), sample_index);
    if (indirect.mirror_depth > 0)
        if (const Rgb share = ways.followed(closures.mirrored); share != Rgb(0.0f))
            send(share, mirrored_ray(point, follower.part, own), RayKind::Mirror);
    for (const Lobe& lobe : bent) {
        const vec3& normal = lobe.has_own_normal() ? lobe.normal : own;
        ++way;
        if (const Rgb share = ways.followed(lobe.a); share != Rgb(0.0f))
            send(share, mirrored_ray(point, follower.part, normal), RayKind::Mirror);
        ++way;
        if (const Rgb share = ways.followed(lobe.weight); share != Rgb(0.0f))
            if (const auto ray = bent_ray(scene_, point, follower.part, normal, lobe.ior))
                send(share, *ray, RayKind::Transmission);
    }
}

void ViewPath::see_air(const Follower& follower, float end_m, std::uint32_t seed, std::uint32_t sample_index,
                       PathSample& sample) const {
    const Ray& ray = follower.part;
    thread_local std::vector<FogGlow::Found> found;
    found.clear();
    sent_air_->draw({ray.origin, ray.direction, ray.near_m, end_m}, {seed, sample_index, 0}, found);
    for (const auto& [radiance, group] : found)
        sample.add_light(follower.throughput() * radiance, group, follower.of, {follower.first, false});
}

void ViewPath::see_lamps(const Follower& follower, float end_m, PathSample& sample) const {
    const Ray& ray = follower.part;
    const auto see = [&](const Light& light, const LampHit& hit) {
        if (!(follower.kind == RayKind::Transmission ? light.lights_surfaces.transmission
                                                     : light.lights_surfaces.glossy))
            return;
        Rgb radiance = light.strength * hit.radiance_per_strength;
        if (light.kind == LightKind::Spot)
            radiance *= spot_attenuation(light, -ray.direction);
        if (light.texture)
            radiance *= texture_colour(
                light, light.kind == LightKind::Sun ? light.position : ray.origin + hit.far_m * ray.direction,
                ray.origin);
        Ray before = ray;
        before.far_m = hit.far_m;
        if (!media_.is_empty())
            radiance *= media_.transmittance(before);
        sample.add_light(follower.throughput() * radiance, light.light_group, follower.of, follower.way_of_shine());
    };
    for (std::size_t lamp = 0; lamp < light_.lamp_count(); ++lamp) {
        const LightAim& aim = light_.aim_of(lamp);
        const Light& light = scene_.lights()[light_.index_of(lamp)];
        if (!aim.has_size() ||
            !(light.links.lights_all() || light.links.lights(scene_.object_info(follower.sender).receiver_set)))
            continue;
        const LampHit hit = lamp_hit(aim.form(), ray.origin, ray.direction);
        if (hit.pdf_per_sr > 0.0f && hit.far_m >= ray.near_m && hit.far_m <= end_m)
            see(light, hit);
    }
    if (!light_.has_many())
        return;
    Ray up_to_end = ray;
    up_to_end.far_m = end_m;
    thread_local std::vector<ManyLights::LampMet> met;
    light_.meet_many_lamps(up_to_end, met);
    for (const auto& [number, hit] : met)
        see(scene_.lights()[light_.many_lamps()[number]], hit);
}
} // namespace tyndall::render
