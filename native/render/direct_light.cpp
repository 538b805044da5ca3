// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/direct_light.hpp"
#include "core/sampling.hpp"
#include "light_shafts/map_cache.hpp"
#include "light_shafts/occluders.hpp"
#include "light_shafts/ray_outline.hpp"
#include "render/lamp_hits.hpp"
#include "render/light_groups.hpp"
#include "render/shadow_rays.hpp"
#include "render/shadow_terminator.hpp"
#include "scene/light_texture.hpp"
#include "shading/surface_program.hpp"
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace tyndall::render {
using light_shafts::SurfaceShadows;

DirectLight::DirectLight(const Scene& scene, const Media& media, Statistics& statistics, const IndirectConfig& indirect,
                         KeptLightTrees* kept, const Progress& progress)
    : scene_(scene), media_(media), emitters_(emitters_of(scene, kept, progress)), has_media_(!media.is_empty()),
      has_world_light_(!scene.world().is_black() && !scene.world().lights_surfaces().are_none()),
      world_reach_m_(indirect.reach_m()) {
    for (std::uint32_t index = 0; index < scene.lights().size(); ++index) {
        const Light& light = scene.lights()[index];
        if (light.lights_surfaces.are_none() || light.strength == Rgb(0.0f))
            continue;
        lights_.push_back({index, LightAim(light), light_shafts::SurfaceHoles::make(scene, light), nullptr, nullptr});
        if (light.kind == LightKind::Sun && light.is_dimmed_by_media() && media.fills_world())
            statistics.report("Light \"" + light.name +
                              "\" is infinitely far away in the world's endless medium, which lets nothing of it "
                              "through: bound the fog with a fog box");
    }
    const auto is_drawn = [&](const AimedLight& aimed) {
        const Light& light = scene.lights()[aimed.index];
        return light.kind != LightKind::Sun && !aimed.holes && !SurfaceShadows::are_cast_by(light) &&
               light.links == LightLinks{} && light.lights_surfaces.are_all();
    };
    std::vector<std::uint32_t> drawn;
    if (static_cast<std::size_t>(std::ranges::count_if(lights_, is_drawn)) > ManyLights::most_asked_each) {
        for (const AimedLight& aimed : lights_)
            if (is_drawn(aimed))
                drawn.push_back(aimed.index);
        std::erase_if(lights_, is_drawn);
    }
    if (!drawn.empty() || !emitters_->is_empty()) {
        const StageTimer timer(statistics, "light tree");
        if (auto many = std::make_unique<const ManyLights>(scene, std::move(drawn), emitters_, kept); !many->is_empty())
            many_ = std::move(many);
    }
    report_glow(statistics);
    if (has_world_light_ && media.fills_world())
        statistics.report("World \"" + scene.world().name() +
                          "\" shines through its own endless medium, which lets nothing through: bound the fog with a "
                          "fog box");
    ray_counts_.assign(light_count(), 1);
    turns_.assign(light_count(), 1);
}

void DirectLight::report_glow(Statistics& statistics) const {
    const SceneDescription& description = scene_.description();
    for (const std::uint32_t shape : emitters_->met_alone())
        if (!scene_.object_info(shape).links.is_blocked_by_all())
            statistics.report("Object \"" + description.object_names[description.name_index_of(shape)] +
                              "\": shadow linking does not reach the glow of voxels, hair and points: all block it");
}

void DirectLight::prepare_edits(std::span<const std::uint8_t> is_asked, const Camera& camera,
                                const light_shafts::Config& shafts, Statistics& statistics, const Progress& progress) {
    std::shared_ptr<const light_shafts::Occluders> occluders;
    std::vector<light_shafts::RaySpan> outline;
    for (std::size_t index = 0; index < lights_.size(); ++index) {
        AimedLight& aimed = lights_[index];
        if (is_asked[index] == 0 || aimed.shadows || !SurfaceShadows::are_cast_by(scene_.lights()[aimed.index]))
            continue;
        const StageTimer timer(statistics, "direct light: edited occluders");
        if (!occluders) {
            occluders = shafts.kept_maps ? shafts.kept_maps->occluders_of(scene_, progress)
                                         : std::make_shared<const light_shafts::Occluders>(
                                               light_shafts::gather_occluders(scene_.description(), progress));
            outline = SurfaceShadows::outline_of(scene_, camera, progress);
        }
        const LightLinks& links = scene_.lights()[aimed.index].links;
        if (!links.is_blocked_by_all())
            aimed.blockers = light_shafts::blocking(scene_, *occluders, links, progress);
        aimed.shadows = std::make_unique<const SurfaceShadows>(
            scene_, aimed.blockers ? *aimed.blockers : *occluders, aimed.index, light_shafts::view_of(camera), outline,
            SurfaceShadows::config_of(camera, shafts), statistics, progress);
    }
}

Ray DirectLight::shadow_ray(const SurfacePoint& point, const vec3& direction) const {
    Ray ray = point.ray_towards(direction);
    if (point.is_smooth)
        ray.origin += terminator_lift(scene_, point.hit, point.shading, direction);
    return ray;
}

LitPoints lanes_of(std::span<const SurfacePoint> points) {
    LitPoints lanes;
    for (std::size_t lane = 0; lane < points.size(); ++lane) {
        const SurfacePoint& point = points[lane];
        lanes.set(lane, point.shading.position, point.shading.shading_normal, point.spawn, point.pixel_seed);
    }
    return lanes;
}

bool DirectLight::has_strata(std::size_t light) const {
    return light >= lights_.size() || lights_[light].aim.has_size();
}

void DirectLight::at(std::span<const SurfacePoint> points, const PairIndex& first_pair,
                     std::span<const std::uint8_t> is_asked, std::span<Irradiance> irradiance, const PointLobes* lobes,
                     std::span<Irradiance> many_by_group, Among among) const {
    const LitPoints lanes = lanes_of(points);
    MostPdfs most_pdfs;
    if (lobes != nullptr)
        most_pdfs.fill(-1.0f);
    for (std::size_t light = 0; light < light_count(); ++light) {
        if (is_asked[light] == 0)
            continue;
        const std::span<Irradiance> of_light = irradiance.subspan(light * points.size(), points.size());
        std::ranges::fill(of_light, Irradiance{});
        add(light, count_of(light), {points, lanes, lobes, among, &most_pdfs}, first_pair, of_light, many_by_group);
    }
}

void DirectLight::add_one(std::size_t light, std::span<const SurfacePoint> points, const PairIndex& first_pair,
                          std::span<Irradiance> irradiance, const PointLobes* lobes) const {
    MostPdfs most_pdfs;
    most_pdfs.fill(-1.0f);
    add(light, count_of(light), {points, lanes_of(points), lobes, Among::All, &most_pdfs}, first_pair, irradiance);
}

void DirectLight::add_all_once(std::span<const SurfacePoint> points, const PairIndex& first_pair,
                               std::span<Irradiance> irradiance, const PointLobes* lobes,
                               std::span<Irradiance> by_group, Among among) const {
    const LitPoints lanes = lanes_of(points);
    std::array<Irradiance, most_points> before;
    MostPdfs most_pdfs;
    if (lobes != nullptr)
        most_pdfs.fill(-1.0f);
    for (std::size_t light = 0; light < light_count(); ++light) {
        const bool is_grouped = !by_group.empty() && !is_many(light) && group_of(light) != no_light_group;
        if (is_grouped)
            std::ranges::copy(irradiance.first(points.size()), before.begin());
        add(light, {}, {points, lanes, lobes, among, &most_pdfs}, first_pair, irradiance, by_group);
        for (std::size_t point = 0; is_grouped && point < points.size(); ++point) {
            Irradiance more; // the sums keep the bits that they have without groups
            more.from_lights = irradiance[point].from_lights - before[point].from_lights;
            more.from_world = irradiance[point].from_world - before[point].from_world;
            more.reflected = irradiance[point].reflected - before[point].reflected;
            add_to_group(by_group, group_of(light), points.size(), point, more);
        }
    }
}

void DirectLight::add(std::size_t light, const RayCount& count, const LitSurface& surface, const PairIndex& first_pair,
                      std::span<Irradiance> irradiance, std::span<Irradiance> many_by_group) const {
    if (!is_on_turn(light, count, first_pair) ||
        (light < lights_.size() && lights_[light].aim.may_light(surface.lanes) == 0))
        return;
    if (surface.among == Among::Catchers && light < lights_.size() && !scene_.lights()[index_of(light)].lights_catchers)
        return;
    const LitKinds kinds = is_many(light)    ? LitKinds{}
                           : is_world(light) ? scene_.world().lights_surfaces()
                                             : scene_.lights()[index_of(light)].lights_surfaces;
    if (!kinds.are_all())
        add_by_kinds(light, kinds, count, surface, first_pair, irradiance);
    else
        add_rays(light, count, surface, first_pair, irradiance, many_by_group);
}

/// A light has the same pair wherever it shines: what one point skips does not shift another light's numbers.
PairIndex DirectLight::pair_of(std::size_t light, std::uint32_t ray, const RayCount& count,
                               const PairIndex& first_pair) {
    return {first_pair.sample_index / count.turn * count.rays + ray,
            first_pair.pair_index + static_cast<std::uint32_t>(light)};
}

void DirectLight::finish(const Light& light, const SurfacePoint& point, Ray& ray, Rgb& arriving) const {
    ray.passed_count = point.passed_count;
    if (light.kind == LightKind::Spot)
        arriving *= spot_attenuation(light, -ray.direction);
    if (light.texture && arriving != Rgb(0.0f)) {
        const vec3 emitter = light.kind == LightKind::Sun ? light.position : ray.origin + ray.far_m * ray.direction;
        arriving *= texture_colour(light, emitter, point.shading.position);
    }
    if (light.kind != LightKind::Sun)
        return lift(point, ray);
    if (point.is_smooth)
        ray.origin += terminator_lift(scene_, point.hit, point.shading, ray.direction);
}

void DirectLight::lift(const SurfacePoint& point, Ray& ray) const {
    const vec3 by = point.is_smooth ? terminator_lift(scene_, point.hit, point.shading, ray.direction) : vec3(0.0f);
    if (by == vec3(0.0f))
        return;
    const vec3 target = ray.origin + ray.far_m * ray.direction;
    ray.origin += by;
    const vec3 to_light = target - ray.origin;
    ray.far_m = glm::length(to_light);
    ray.direction = to_light / ray.far_m;
}

void DirectLight::aim(const AimedLight& aimed, std::span<const SurfacePoint> points, const LitPoints& lanes,
                      const PairIndex& pair, float share, ShadowRays& shadow) const {
    const Light& light = scene_.lights()[aimed.index];
    AimedRays towards;
    for (LaneSet left = aimed.aim.aim(lanes, pair, towards); left != 0; left &= left - 1) {
        const auto lane = static_cast<std::size_t>(std::countr_zero(left));
        if (!may_light(light.links, points[lane]))
            continue;
        Ray ray = ray_of(towards, lane);
        Rgb arriving = share * towards.weight[lane] * light.strength;
        finish(light, points[lane], ray, arriving);
        if (arriving != Rgb(0.0f))
            shadow.push(ray, arriving, lane);
    }
}

vec3 DirectLight::towards_lamp(const Light& light, const SurfacePoint& point, const Ray& ray) {
    if (!point.is_smooth || light.kind == LightKind::Sun)
        return ray.direction;
    return glm::normalize(ray.origin + ray.far_m * ray.direction - point.spawn.towards(ray.direction));
}

void DirectLight::let_pass(const AimedLight& aimed, const LitSurface& surface, ShadowRays& shadow) const {
    const Light& light = scene_.lights()[aimed.index];
    const bool is_among_all = surface.among == Among::All; // else neither edits nor media count
    if (light.casts_shadow && aimed.holes && is_among_all)
        aimed.holes->shadow_transmittances(shadow.all(), shadow.passing);
    else if (light.casts_shadow && !light.links.is_blocked_by_all())
        scene_.shadow_transmittances(shadow.all(), shadow.passing, light.links, surface.among);
    else if (light.casts_shadow)
        scene_.shadow_transmittances(shadow.all(), shadow.passing, {}, 0, surface.among);
    else
        shadow.passing.fill(Rgb(1.0f));
    if (!is_among_all)
        return;
    for (std::size_t index = 0; aimed.shadows && index < shadow.count; ++index) {
        const ShadingPoint& point = surface.points[shadow.points[index]].shading;
        if (aimed.shadows->is_dark(point.position, point.geometric_normal, shadow.rays[index]))
            shadow.passing[index] = Rgb(0.0f);
    }
    if (has_media_ && light.is_dimmed_by_media())
        media_.attenuate(shadow.all(), shadow.passing);
}

void DirectLight::add_light(const AimedLight& aimed, const LitSurface& surface, const PairIndex& pair, float share,
                            std::span<Irradiance> irradiance) const {
    ShadowRays shadow;
    aim(aimed, surface.points, surface.lanes, pair, share, shadow);
    for (std::size_t index = 0; surface.lobes != nullptr && index < shadow.count; ++index) {
        const LobeSet& lobes = (*surface.lobes)[shadow.points[index]];
        if (lobes.lobes.empty())
            continue;
        const vec3 direction =
            towards_lamp(scene_.lights()[aimed.index], surface.points[shadow.points[index]], shadow.rays[index]);
        float weight = 1.0f;
        const vec3& position = surface.points[shadow.points[index]].shading.position;
        if (aimed.aim.has_size() && may_find(aimed, surface, shadow.points[index])) {
            if (const LampHit hit = lamp_hit(aimed.aim.form(), position, direction); hit.pdf_per_sr > 0.0f)
                weight = power_share(hit.pdf_per_sr, lobes.pdf_per_sr(direction));
        }
        const Rgb per_irradiance =
            aimed.aim.has_size() ? lobes.per_irradiance(direction) : lobes.per_irradiance_of_point(direction);
        shadow.reflected[index] = shadow.arriving[index] * per_irradiance * weight;
    }
    let_pass(aimed, surface, shadow);
    for (std::size_t index = 0; index < shadow.count; ++index) {
        Irradiance& sum = irradiance[shadow.points[index]];
        sum.unshadowed += shadow.arriving[index];
        sum.from_lights += shadow.arriving[index] * shadow.passing[index];
        sum.reflected += shadow.reflected[index] * shadow.passing[index];
    }
    if (surface.lobes == nullptr || !aimed.aim.has_size())
        return;
    shadow.count = 0;
    aim_by_lobes(aimed, surface, pair, share, shadow);
    if (shadow.count == 0)
        return;
    let_pass(aimed, surface, shadow);
    for (std::size_t index = 0; index < shadow.count; ++index)
        irradiance[shadow.points[index]].reflected += shadow.arriving[index] * shadow.passing[index];
}

bool DirectLight::may_find(const AimedLight& aimed, const LitSurface& surface, std::size_t point) {
    const LobeSet& lobes = (*surface.lobes)[point];
    float& most = (*surface.most_pdfs)[point];
    if (most < 0.0f)
        most = lobes.has_directions() ? most_pdf_per_sr(lobes) : 0.0f;
    return most > 0.0f && lobes_may_find(aimed.aim.form(), surface.points[point].shading.position, most);
}

void DirectLight::aim_by_lobes(const AimedLight& aimed, const LitSurface& surface, const PairIndex& pair, float share,
                               ShadowRays& shadow) const {
    const Light& light = scene_.lights()[aimed.index];
    for (std::size_t index = 0; index < surface.points.size(); ++index) {
        const LobeSet& lobes = (*surface.lobes)[index];
        const SurfacePoint& point = surface.points[index];
        if (!may_light(light.links, point) || !may_find(aimed, surface, index))
            continue;
        constexpr std::uint32_t lobe_pairs = 0x1000'0000; // far behind those of strata
        const vec3 direction =
            lobes.sample(pixel_pair(point.pixel_seed, pair.sample_index, lobe_pairs + pair.pair_index));
        const float cosine = glm::dot(point.shading.shading_normal, direction);
        const LampHit hit = lamp_hit(aimed.aim.form(), point.shading.position, direction);
        if (!(cosine > 0.0f) || hit.pdf_per_sr <= 0.0f)
            continue;
        const float pdf = lobes.pdf_per_sr(direction);
        if (!(pdf > 0.0f))
            continue;
        Ray ray{.origin = point.spawn.towards(direction), .direction = direction, .far_m = hit.far_m};
        const float weight = power_share(pdf, hit.pdf_per_sr) * cosine / pdf;
        Rgb arriving =
            light.strength * (share * weight * hit.radiance_per_strength) * lobes.per_irradiance_as_drawn(direction);
        finish(light, point, ray, arriving);
        if (arriving != Rgb(0.0f))
            shadow.push(ray, arriving, index);
    }
}

LaneSet DirectLight::may_meet(std::size_t light, std::span<const SurfacePoint> points, const PairIndex& first_pair,
                              const MovedBoxes& boxes, const PointLobes* lobes) const {
    const RayCount ray_count = count_of(light);
    if (!is_on_turn(light, ray_count, first_pair) ||
        (light < lights_.size() && !scene_.lights()[lights_[light].index].casts_shadow))
        return 0;
    const LitPoints lanes = lanes_of(points);
    if (light < lights_.size() && lights_[light].aim.may_light(lanes) == 0)
        return 0;
    MostPdfs most_pdfs;
    most_pdfs.fill(-1.0f);
    const LitSurface surface{points, lanes, lobes, Among::All, &most_pdfs};
    LaneSet found = 0;
    ShadowRays shadow;
    const auto test = [&] {
        for (std::size_t index = 0; index < shadow.count; ++index)
            if (const LaneSet lane = LaneSet{1} << shadow.points[index]; (found & lane) == 0)
                found |= boxes.may_meet(shadow.rays[index]) ? lane : 0;
        shadow.count = 0;
    };
    for (std::uint32_t ray = 0; ray < ray_count.rays; ++ray) {
        const PairIndex pair = pair_of(light, ray, ray_count, first_pair);
        if (is_many(light)) {
            aim_at_many(surface, pair, 1.0f, shadow);
            test();
            for (std::size_t index = 0; lobes != nullptr && index < points.size(); ++index) {
                if ((found >> index & 1) != 0 || !finds_lamps((*lobes)[index]))
                    continue;
                thread_local std::vector<RayToLamp> rays;
                rays.clear();
                if (const auto drawn = draw_by_lobes(points[index], (*lobes)[index], pair))
                    aim_at_lamps_met(points[index], (*lobes)[index], *drawn, 1.0f, Among::All, rays);
                if (std::ranges::any_of(rays, [&](const RayToLamp& to) { return boxes.may_meet(to.ray); }))
                    found |= LaneSet{1} << index;
            }
            continue;
        }
        if (!is_world(light)) {
            aim(lights_[light], points, lanes, pair, 1.0f, shadow);
            test();
            if (lobes != nullptr && lights_[light].aim.has_size()) {
                aim_by_lobes(lights_[light], surface, pair, 1.0f, shadow);
                test();
            }
            continue;
        }
        aim_at_world(surface, pair, 1.0f, shadow);
        test();
    }
    return found;
}

bool DirectLight::is_told_by_rays(std::size_t light) const {
    if (is_many(light)) // where a light stands, no ray to where it is now tells
        return !many_->has_glow();
    return is_world(light) || std::ranges::none_of(scene_.lights()[index_of(light)].occluder_edits,
                                                   [](const OccluderEdit& edit) { return edit.affects_surfaces; });
}
} // namespace tyndall::render
