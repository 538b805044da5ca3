// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/indirect_light.hpp"
#include "core/errors.hpp"
#include "render/light_groups.hpp"
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
      has_bounce_(config.has_bounce && shines(scene, media, light)) {}

void IndirectLight::add(const SurfaceWalk& walked, std::uint32_t sample_index, std::span<PathSample> samples,
                        std::size_t group_count, const Progress& progress) const {
    std::array<Rgb, DirectLight::most_points> found;
    thread_local std::vector<Rgb> by_group;
    std::size_t first = 0;
    for (const auto [end, layer, among] : walked.batches) {
        progress.poll();
        const auto points = std::span(walked.points).subspan(first, end - first);
        const auto shades = std::span(walked.shades).subspan(first, end - first);
        if (finds_ambient_ && among == Among::All) {
            found.fill(Rgb(0.0f));
            find_ambient(points, sample_index, layer, found);
            for (std::size_t i = 0; i < points.size(); ++i)
                samples[shades[i].sample].ambient += shades[i].cover * found[i];
        }
        if (has_bounce_) {
            found.fill(Rgb(0.0f));
            by_group.assign(group_count * points.size(), Rgb(0.0f));
            gather(points, sample_index, layer, bounce_rays_, found, by_group, among);
            const auto add = [&](std::size_t point, const Rgb& per_irradiance) {
                PathSample& sample = samples[shades[point].sample];
                sample.light_of(shades[point].of) += per_irradiance * found[point];
                if (shades[point].of != LightOf::Picture)
                    return;
                for (std::size_t group = 0; group < sample.by_group.size(); ++group)
                    sample.by_group[group] += per_irradiance * by_group[group * points.size() + point];
            };
            for (std::size_t i = 0; i < points.size(); ++i)
                add(i, shades[i].radiance);
            for (const SurfaceWalk::LobedPoint& of : walked.lobed_of(first, end)) // as if they were diffuse
                add(of.point - first, of.throughput * walked.lobes_of(of).albedo() * std::numbers::inv_pi_v<float>);
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
    Rgb weight; ///< Irradiance per radiance.
};

void IndirectLight::gather(std::span<const SurfacePoint> points, std::uint32_t sample_index, std::uint32_t layer,
                           std::uint32_t ray_count, std::span<Rgb> irradiance, std::span<Rgb> by_group,
                           Among among) const {
    const LitPoints lanes = lanes_of(points);
    thread_local std::vector<Gatherer> gatherers;
    for (std::uint32_t ray = 0; ray < ray_count; ++ray) {
        const std::uint32_t sample = sample_index * ray_count + ray;
        AimedRays aimed;
        gatherers.clear();
        for (LaneSet left = LightAim::aim_at_world(lanes, {sample, first_gather_pair + layer}, aimed); left != 0;
             left &= left - 1) {
            const auto lane = static_cast<std::size_t>(std::countr_zero(left));
            const ShadingPoint& shading = points[lane].shading;
            const vec3 direction = aimed.direction.get(lane);
            // Above the shading normal's horizon, but below the surface's own: nothing is there.
            if ((glm::dot(direction, shading.geometric_normal) > 0.0f) == shading.is_backface)
                continue;
            const Ray part{
                .origin = aimed.origin.get(lane), .direction = direction, .near_m = 0.0f, .far_m = config_.reach_m()};
            gatherers.push_back({lane, part, Rgb(pi / static_cast<float>(ray_count))});
        }
        for (std::uint32_t passed = 0; passed < max_layer_count && !gatherers.empty(); ++passed) {
            const std::uint32_t place = layer * layers_apart + std::min(passed, layers_apart - 1);
            catch_light(points, gatherers, {sample, first_gathered_pair + place * pairs_per_gathered_layer}, irradiance,
                        by_group, among);
        }
    }
}

void IndirectLight::catch_light(std::span<const SurfacePoint> points, std::vector<Gatherer>& gatherers,
                                const PairIndex& first_pair, std::span<Rgb> irradiance, std::span<Rgb> by_group,
                                Among among) const {
    std::array<SurfacePoint, DirectLight::most_points> met;
    std::array<Rgb, DirectLight::most_points> weights; ///< Irradiance per irradiance.
    std::array<std::size_t, DirectLight::most_points> caught_by;
    std::size_t met_count = 0, going_on = 0;
    for (Gatherer& gatherer : gatherers) {
        const auto& [point, part, weight] = gatherer;
        const Hit hit = scene_.closest_hit(part, mask_among(among, bounce_mask));
        if (!media_.is_empty() && among == Among::All) {
            Ray inside = part;
            if (hit.is_hit())
                inside.far_m = hit.distance_m;
            irradiance[point] += weight * media_.emission(inside);
            gatherer.weight *= media_.transmittance(inside);
        }
        if (!hit.is_hit())
            continue; // the world's light comes straight
        const SurfacePoint surface = surface_point(scene_, part, hit, points[point].pixel_seed);
        const ProgramRandom random{hash(points[point].pixel_seed, first_pair.pair_index), first_pair.sample_index};
        const SurfaceClosures closures =
            scene_.closures({.ray = part, .kind = RayKind::Diffuse, .random = random}, surface.shading, hit);
        if (!light_.is_light(hit) && closures.emission != Rgb(0.0f)) {
            irradiance[point] += weight * closures.emission;
            if (!by_group.empty())
                add_to_group(by_group, scene_.object_info(hit.instance).light_group, points.size(), point,
                             weight * closures.emission);
        }
        if (closures.diffuse_albedo != Rgb(0.0f)) {
            met[met_count] = surface;
            weights[met_count] = weight * closures.diffuse_albedo * std::numbers::inv_pi_v<float>;
            caught_by[met_count++] = point;
        }
        gatherer.weight *= closures.transparent;
        if (gatherer.weight == Rgb(0.0f))
            continue;
        gatherer.part.near_m = std::nextafter(hit.distance_m * (1.0f + 4e-7f), gatherer.part.far_m);
        gatherers[going_on++] = gatherer;
    }
    gatherers.resize(going_on);
    if (met_count == 0)
        return;
    std::array<DirectLight::Irradiance, DirectLight::most_points> lit{};
    const std::size_t group_count = by_group.empty() ? 0 : by_group.size() / points.size();
    thread_local std::vector<DirectLight::Irradiance> lit_by_group;
    lit_by_group.assign(group_count * met_count, {});
    light_.add_all_once(std::span(met).first(met_count), first_pair, lit, lit_by_group, among);
    for (std::size_t i = 0; i < met_count; ++i) {
        irradiance[caught_by[i]] += weights[i] * lit[i].sum();
        for (std::size_t group = 0; group < group_count; ++group)
            by_group[group * points.size() + caught_by[i]] += weights[i] * lit_by_group[group * met_count + i].sum();
    }
}
} // namespace tyndall::render
