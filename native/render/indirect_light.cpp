// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/indirect_light.hpp"
#include "core/errors.hpp"
#include "core/sampling.hpp"
#include "render/light_groups.hpp"
#include "render/passed_surface.hpp"
#include "render/surface_directions.hpp"
#include "render/view_path.hpp"
#include "shading/surface_program.hpp"
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>

namespace tyndall::render {
// Random pairs, beyond those of the light that reaches surfaces straight: two kinds of directions by layer, and the lights
// of what a gathering ray meets by layer and by its own layers.
static constexpr std::uint32_t first_ambient_pair = 0x2000'0000, first_gather_pair = 0x4000'0000;
static constexpr std::uint32_t first_gathered_pair = 0x8000'0000, pairs_per_gathered_layer = 256, layers_apart = 16;

void require_usable(const IndirectConfig& config) {
    require_in(config.ambient_distance_m, 0.0f, 1e9f, "ambient_distance_m");
    require(1 <= config.ambient_samples && config.ambient_samples <= 1024, "ambient_samples is ",
            config.ambient_samples, ", outside [1, 1024]");
    require(config.bounce_samples <= 1024, "bounce_samples is ", config.bounce_samples, ", outside [0, 1024]");
    require(config.mirror_depth <= 64, "mirror_depth is ", config.mirror_depth, ", outside [0, 64]");
    require(config.refraction_depth <= 64, "refraction_depth is ", config.refraction_depth, ", outside [0, 64]");
}

/// Lamps, the world, a surface or the air.
static bool shines(const Scene& scene, const Media& media, const DirectLight& light) {
    return light.light_count() > 0 || !media.is_empty() ||
           !std::ranges::all_of(scene.description().materials, glows_nowhere);
}

IndirectLight::IndirectLight(const Scene& scene, const Media& media, const DirectLight& light,
                             const IndirectConfig& config, bool finds_ambient)
    : scene_(scene), media_(media), light_(light), config_(config), finds_ambient_(finds_ambient),
      sees_surfaces_(config.has_bounce && shines(scene, media, light)),
      has_bounce_(sees_surfaces_ || (media.emits(GlowSeenBy::Surfaces) && !media.is_empty())) {}

void IndirectLight::add(const SurfaceWalk& walked, std::uint32_t sample_index, std::span<PathSample> samples,
                        std::size_t group_count, const Progress& progress) const {
    std::array<Rgb, DirectLight::most_points> seen;
    std::array<Gathered, DirectLight::most_points> found;
    thread_local std::vector<Gathered> by_group;
    std::size_t first = 0;
    for (const auto [end, layer, among] : walked.batches) {
        progress.poll();
        const auto points = std::span(walked.points).subspan(first, end - first);
        const auto shades = std::span(walked.shades).subspan(first, end - first);
        if (finds_ambient_ && among == Among::All) {
            seen.fill(Rgb(0.0f));
            find_ambient(points, sample_index, layer, seen);
            for (std::size_t i = 0; i < points.size(); ++i)
                samples[shades[i].sample].ambient += shades[i].cover * seen[i];
        }
        if (has_bounce_ && (sees_surfaces_ || among == Among::All)) {
            found.fill({});
            by_group.assign(group_count * points.size(), {});
            const std::span<const SurfaceWalk::LobedPoint> lobed = walked.lobed_of(first, end);
            DirectLight::PointLobes lobes;
            for (const SurfaceWalk::LobedPoint& of : lobed)
                lobes[of.point - first] = walked.lobes_of(of);
            gather(points, sample_index, layer, bounce_rays_, lobed.empty() ? nullptr : &lobes,
                   std::span(found).first(points.size()), by_group, among);
            const auto add = [&](std::size_t point, const Rgb& share, Rgb Gathered::*of) {
                PathSample& sample = samples[shades[point].sample];
                sample.add_light(share * found[point].*of, shades[point].of, {shades[point].way.by, !sees_surfaces_});
                if (shades[point].of != LightOf::Picture)
                    return;
                for (std::size_t group = 0; group < sample.by_group.size(); ++group)
                    sample.by_group[group] += share * by_group[group * points.size() + point].*of;
            };
            for (std::size_t i = 0; i < points.size(); ++i)
                add(i, shades[i].radiance, &Gathered::irradiance);
            for (const SurfaceWalk::LobedPoint& of : lobed)
                add(of.point - first, of.throughput, &Gathered::reflected);
        }
        first = end;
    }
}

void IndirectLight::find_ambient(std::span<const SurfacePoint> points, std::uint32_t sample_index, std::uint32_t layer,
                                 std::span<Rgb> seen) const {
    const LitPoints lanes = lanes_of(points);
    const float share = 1.0f / static_cast<float>(config_.ambient_samples);
    for (std::uint32_t ray = 0; ray < config_.ambient_samples; ++ray) {
        AimedRays aimed;
        const PairIndex pair{sample_index * config_.ambient_samples + ray, first_ambient_pair + layer};
        for (LaneSet left = LightAim::aim_at_world(lanes, pair, aimed); left != 0; left &= left - 1) {
            const auto lane = static_cast<std::size_t>(std::countr_zero(left));
            seen[lane] += share * scene_.shadow_transmittance({.origin = aimed.origin.get(lane),
                                                               .direction = aimed.direction.get(lane),
                                                               .near_m = 0.0f,
                                                               .far_m = config_.ambient_reach_m()});
        }
    }
}

/// A ray on its way from a point.
struct IndirectLight::Gatherer {
    std::size_t point;
    Ray part;
    Rgb weight;                      ///< Irradiance per radiance.
    float pdf_per_sr;                ///< Of its direction.
    Rgb reflected{0.0f};             ///< What the point's lobes make of irradiance, 1/sr.
    RayKind kind = RayKind::Diffuse; ///< Glossy: drawn by lobes.

    [[nodiscard]] Gathered of(const Rgb& radiance) const { return {weight * radiance, weight * radiance * reflected}; }
};

/// One side of what rays met, which waits for light.
struct IndirectLight::Met {
    std::array<SurfacePoint, DirectLight::most_points> points;
    std::array<Gatherer, DirectLight::most_points> caught_by;
    std::array<Rgb, DirectLight::most_points> albedos; ///< Lambert's.
    std::array<Lobes, DirectLight::most_points> lobes;
    std::size_t count = 0;

    void push(const SurfacePoint& point, const Gatherer& by, const Rgb& albedo, Lobes& of_point) {
        points[count] = point;
        points[count].lambert_share = average(albedo);
        caught_by[count] = by;
        albedos[count] = albedo;
        lobes[count++].swap(of_point);
    }
};

/// Where a ray of this density ends: what is below the surface, and hair, count as diffuse, glass lets all pass straight,
/// and gloss is as wide as Cycles' Filter Glossy makes it by default, as few rays would see where it is narrow, but all the
/// brighter. Cycles leaves it as narrow as it is behind rays by sharp gloss: so added glass under a sun had pixels of 1e7.
static void blur(Lobes& lobes, float pdf_per_sr, SurfaceClosures& closures) {
    constexpr float narrowest = 0.1f; // a roughness of 0.32
    const float least_alpha = std::max(0.5f * std::sqrt(std::max(1.0f - pdf_per_sr, 0.0f)), narrowest);
    std::erase_if(lobes, [&](const Lobe& lobe) {
        const bool is_even = lobe.kind == Lobe::Kind::Subsurface || lobe.is_of_fibre();
        const bool is_bent = lobe.kind == Lobe::Kind::Bent;
        if (is_even)
            closures.diffuse_albedo += lobe.weight;
        if (is_bent)
            closures.transparent += lobe.weight + lobe.a;
        return is_even || is_bent;
    });
    for (Lobe& lobe : lobes)
        if (lobe.is_of_facets() && lobe.alpha < least_alpha) {
            lobe.alpha = lobe.own_alpha = least_alpha;
            lobe.tangent = vec3(0.0f);
            if (lobe.kind == Lobe::Kind::GgxAlongTangent)
                lobe.kind = Lobe::Kind::Ggx;
        }
}

void IndirectLight::push_drawn(const SurfacePoint& point, const LobeSet& lobes, vec2 u, Gatherer ray,
                               std::vector<Gatherer>& gatherers) {
    const SurfaceDirections own(point, lobes);
    const vec3 direction = own.sample(u);
    const float cosine = counted_cosine(point, lobes, direction);
    if (cosine == 0.0f || point.is_below_surface(direction)) // nothing is there
        return;
    const float density = own.pdf_per_sr(direction);
    if (!(density > 0.0f) || !std::isfinite(density))
        return;
    ray.part.origin = point.spawn.towards(direction);
    ray.part.direction = direction;
    ray.part.passed_count = point.passed_count;
    ray.weight *= cosine / density;
    ray.pdf_per_sr = density;
    ray.reflected = lobes.per_irradiance_as_drawn(direction);
    ray.kind = own.is_by_lobes(u) ? RayKind::Glossy : RayKind::Diffuse;
    gatherers.push_back(ray);
}

void IndirectLight::gather(std::span<const SurfacePoint> points, std::uint32_t sample_index, std::uint32_t layer,
                           std::uint32_t ray_count, const DirectLight::PointLobes* lobes, std::span<Gathered> gathered,
                           std::span<Gathered> by_group, Among among) const {
    LitPoints lanes = lanes_of(points);
    LaneSet lobed = 0;
    for (std::size_t point = 0; lobes != nullptr && point < points.size(); ++point)
        if (!(*lobes)[point].lobes.empty())
            lobed |= LaneSet{1} << point;
    lanes.present &= ~lobed;
    const Rgb share(1.0f / static_cast<float>(ray_count));
    thread_local std::vector<Gatherer> gatherers;
    for (std::uint32_t ray = 0; ray < ray_count; ++ray) {
        const std::uint32_t sample = sample_index * ray_count + ray;
        const PairIndex pair{sample, first_gather_pair + layer};
        Ray part{.origin = {}, .direction = {}, .near_m = 0.0f, .far_m = config_.reach_m()};
        AimedRays aimed;
        gatherers.clear();
        for (LaneSet left = LightAim::aim_at_world(lanes, pair, aimed); left != 0; left &= left - 1) {
            const auto lane = static_cast<std::size_t>(std::countr_zero(left));
            part.origin = aimed.origin.get(lane);
            part.direction = aimed.direction.get(lane);
            part.passed_count = points[lane].passed_count;
            const float cosine = glm::dot(points[lane].shading.shading_normal, part.direction);
            if (!points[lane].is_below_surface(part.direction))
                gatherers.push_back({lane, part, pi * share, cosine_hemisphere_pdf_per_sr(cosine)});
        }
        for (LaneSet left = lobed; left != 0; left &= left - 1) {
            const auto point = static_cast<std::size_t>(std::countr_zero(left));
            const vec2 u = pixel_pair(points[point].pixel_seed, pair.sample_index, pair.pair_index);
            push_drawn(points[point], (*lobes)[point], u, {point, part, share, 0.0f}, gatherers);
        }
        for (std::uint32_t passed = 0; passed < max_layer_count && !gatherers.empty(); ++passed) {
            if (!sees_surfaces_) {
                catch_glow(gatherers, gathered);
                continue;
            }
            const std::uint32_t place = layer * layers_apart + std::min(passed, layers_apart - 1);
            catch_light(points, gatherers, {sample, first_gathered_pair + place * pairs_per_gathered_layer}, gathered,
                        by_group, among);
        }
    }
}

void IndirectLight::catch_glow(std::vector<Gatherer>& gatherers, std::span<Gathered> gathered) const {
    std::erase_if(gatherers, [&](Gatherer& gatherer) {
        Ray inside = gatherer.part;
        Rgb glow = media_.emission(inside, GlowSeenBy::Surfaces);
        if (glow == Rgb(0.0f))
            return true;
        const Hit hit = scene_.closest_hit(gatherer.part, mask_among(Among::All, blocking_mask(gatherer.kind)));
        if (hit.is_hit()) {
            inside.far_m = hit.distance_m;
            glow = media_.emission(inside, GlowSeenBy::Surfaces);
        }
        gathered[gatherer.point] += gatherer.of(glow);
        if (!hit.is_hit())
            return true;
        gatherer.weight *= media_.transmittance(inside) * scene_.transparency(gatherer.part, hit, gatherer.kind);
        go_on_behind(gatherer.part, hit);
        return gatherer.weight == Rgb(0.0f);
    });
}

void IndirectLight::catch_light(std::span<const SurfacePoint> points, std::vector<Gatherer>& gatherers,
                                const PairIndex& first_pair, std::span<Gathered> gathered, std::span<Gathered> by_group,
                                Among among) const {
    thread_local Met in_front, behind;
    thread_local Lobes lobes;
    in_front.count = behind.count = 0;
    std::size_t going_on = 0;
    for (Gatherer& gatherer : gatherers) {
        const std::size_t point = gatherer.point;
        const Ray& part = gatherer.part;
        const Hit hit = scene_.closest_hit(part, mask_among(among, blocking_mask(gatherer.kind)));
        if (!media_.is_empty() && among == Among::All) {
            Ray inside = part;
            if (hit.is_hit())
                inside.far_m = hit.distance_m;
            gathered[point] += gatherer.of(media_.emission(inside, GlowSeenBy::Surfaces));
            gatherer.weight *= media_.transmittance(inside);
        }
        if (!hit.is_hit())
            continue; // the world's light comes straight
        const SurfacePoint surface = surface_point(scene_, part, hit, points[point].pixel_seed);
        const ProgramRandom random{hash(points[point].pixel_seed, first_pair.pair_index), first_pair.sample_index};
        lobes.clear();
        SurfaceClosures closures =
            scene_.closures({.ray = part, .kind = gatherer.kind, .random = random}, surface.shading, hit, &lobes);
        blur(lobes, gatherer.pdf_per_sr, closures);
        if (!light_.is_light(hit) && closures.emission != Rgb(0.0f)) {
            const Gathered found = gatherer.of(closures.emission);
            gathered[point] += found;
            if (!by_group.empty())
                add_to_group(by_group, scene_.object_info(hit.instance).light_group, points.size(), point, found);
        }
        if (closures.diffuse_albedo != Rgb(0.0f) || !lobes.empty())
            in_front.push(surface, gatherer, closures.diffuse_albedo, lobes);
        lobes.clear();
        if (closures.translucent != Rgb(0.0f))
            behind.push(other_side(scene_, surface), gatherer, closures.translucent, lobes);
        gatherer.weight *= closures.transparent;
        if (gatherer.weight == Rgb(0.0f))
            continue;
        go_on_behind(gatherer.part, hit);
        gatherers[going_on++] = gatherer;
    }
    gatherers.resize(going_on);
    light(in_front, first_pair, gathered, by_group, among);
    light(behind, first_pair, gathered, by_group, among);
}

void IndirectLight::light(const Met& met, const PairIndex& first_pair, std::span<Gathered> gathered,
                          std::span<Gathered> by_group, Among among) const {
    if (met.count == 0)
        return;
    std::array<DirectLight::Irradiance, DirectLight::most_points> lit{};
    const std::size_t group_count = by_group.size() / gathered.size();
    thread_local std::vector<DirectLight::Irradiance> lit_by_group;
    lit_by_group.assign(group_count * met.count, {});
    DirectLight::PointLobes lobes;
    for (std::size_t i = 0; i < met.count; ++i)
        lobes[i] = {.lobes = met.lobes[i],
                    .normal = met.points[i].shading.shading_normal,
                    .outgoing = -met.caught_by[i].part.direction};
    light_.add_all_once(std::span(met.points).first(met.count), first_pair, lit, &lobes, lit_by_group, among);
    for (std::size_t i = 0; i < met.count; ++i) {
        const Gatherer& by = met.caught_by[i];
        const auto sent = [&](const DirectLight::Irradiance& at) {
            return by.of(met.albedos[i] * std::numbers::inv_pi_v<float> * at.sum() + at.reflected);
        };
        gathered[by.point] += sent(lit[i]);
        for (std::size_t group = 0; group < group_count; ++group)
            by_group[group * gathered.size() + by.point] += sent(lit_by_group[group * met.count + i]);
    }
}
} // namespace tyndall::render
