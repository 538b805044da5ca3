// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/view_path.hpp"
#include "render/pixel_footprint.hpp"
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>

namespace tyndall::render {
// Random pairs set aside for the light of one layer: 2 for each of 100 lights and 2 of the world fit; beyond, layers
// share pairs, which adds noise but no bias.
static constexpr std::uint32_t pairs_per_layer = 256;
// Blender's default: a surface that covers less does not show in Depth, Normal and Position.
static constexpr float alpha_threshold = 0.5f;
// Of a mirrored ray, to be followed: between two panes that mirror a little, rays would double at each.
static constexpr float least_mirrored = 1.0f / 1024.0f;

/// A ray on its way.
struct ViewPath::Follower {
    std::size_t index = 0; ///< Of its camera ray.
    float spread = 0.0f;   ///< What a pixel covers, per metre of the way.
    float near_m = 0.0f;   ///< Where the camera's ray began, along it.
    float width_m = 0.0f;  ///< What it covers where `part` begins.
    Ray part{};            ///< What is left of it.
    Rgb through_surfaces{1.0f}, through_media{1.0f};
    FeatureSearch features{}; ///< Where a denoiser is to be shown some.
    bool has_first_surface = false;
    [[nodiscard]] Rgb throughput() const { return through_surfaces * through_media; }
};

/// Seeds and targets as walk() has them.
struct ViewPath::Rays {
    std::span<Follower> followers;
    std::span<const std::uint32_t> pixel_seeds, targets;
    std::span<const RayDetail> details = {}; ///< By the index of a camera ray; empty where every cell is met.
};

void ViewPath::pass_media(Follower& follower, const Hit& hit, PathSample& sample,
                          std::vector<MediumPart>* parts) const {
    Ray inside = follower.part;
    if (hit.is_hit())
        inside.far_m = hit.distance_m;
    const Rgb in_front = follower.throughput();
    if (config_.collects_parts && parts != nullptr)
        parts->push_back({.near_m = inside.near_m, .far_m = inside.far_m, .weight = in_front});
    sample.radiance += in_front * media_.emission(inside);
    follower.through_media *= media_.transmittance(inside);
    if (!follower.has_first_surface)
        sample.transmittance = follower.through_media;
}

void ViewPath::reach_world(const Follower& follower, bool is_in_mirror, PathSample& sample) const {
    if (config_.is_film_transparent && !is_in_mirror)
        sample.alpha -= average(follower.throughput());
    else
        sample.add_light(follower.throughput() * scene_.world().seen_radiance(follower.part.direction),
                         scene_.world().light_group());
}

void ViewPath::show(Follower& follower, const SurfacePoint& point, const SurfaceClosures& closures, bool is_in_mirror,
                    PathSample& sample) const {
    const Rgb throughput = follower.throughput();
    if (closures.emission != Rgb(0.0f))
        sample.add_light(throughput * closures.emission,
                         sample.by_group.empty() ? no_light_group : scene_.object_info(point.hit.instance).light_group);
    if (is_in_mirror)
        return;
    if (!follower.has_first_surface && 1.0f - average(closures.transparent) >= alpha_threshold) {
        follower.has_first_surface = true;
        sample.depth_m = camera_.depth_m(point.shading.position);
        sample.normal = point.shading.shading_normal;
        sample.position = point.shading.position;
    }
    sample.emission += throughput * closures.emission;
    sample.diffuse_colour += throughput * (closures.diffuse_albedo + closures.translucent);
}

/// Of what a camera sees there, the share that is cut out of the picture. All of a held out object is that does not let
/// light pass straight: nothing else is left of it, as in Cycles.
static Rgb cut_out(bool is_held_out, SurfaceClosures& closures, std::vector<Lobe>& lobes) {
    if (!is_held_out)
        return Rgb(closures.held_out);
    closures = {.transparent = closures.transparent};
    lobes.clear();
    return Rgb(1.0f) - closures.transparent;
}

/// The point as light from behind meets it, with random numbers of its own.
static SurfacePoint other_side(SurfacePoint point) {
    point.shading.shading_normal = -point.shading.shading_normal;
    point.shading.is_backface = !point.shading.is_backface;
    point.pixel_seed = hash(point.pixel_seed, 1);
    return point;
}

Ray ViewPath::mirrored_ray(const SurfacePoint& point, const Ray& ray) {
    const ShadingPoint& shading = point.shading;
    const vec3 outside = shading.is_backface ? -shading.geometric_normal : shading.geometric_normal;
    vec3 direction = glm::reflect(ray.direction, shading.shading_normal);
    if (glm::dot(direction, outside) <= 0.0f) // a normal of its own may turn it into the surface
        direction = glm::reflect(ray.direction, outside);
    direction = glm::normalize(direction);
    return {.origin = point.spawn.towards(direction), .direction = direction};
}

void ViewPath::walk(std::span<const Ray> camera_rays, std::span<const std::uint32_t> pixel_seeds,
                    std::uint32_t sample_index, std::span<const std::uint32_t> targets, std::span<PathSample> samples,
                    std::span<std::vector<MediumPart>> parts, SurfaceWalk* walked, const DataOfRays& data) const {
    std::array<Follower, DirectLight::most_points> followers;
    for (std::size_t index = 0; index < camera_rays.size(); ++index) {
        followers[index].index = index;
        followers[index].part = camera_rays[index];
        const PixelFootprint footprint = pixel_footprint(camera_, camera_rays[index].direction);
        followers[index].spread = footprint.spread;
        followers[index].near_m = camera_rays[index].near_m;
        followers[index].width_m = footprint.width_m;
        followers[index].features.passed_m = camera_rays[index].near_m;
        const std::span<Rgb> by_group = samples[index].by_group;
        samples[index] = {};
        samples[index].by_group = by_group;
    }
    std::array<RayDetail, DirectLight::most_points> details; // of camera rays; what mirrors show is met cell by cell
    const bool has_details = config_.voxel_detail_px > 0.0f;
    for (std::size_t index = 0; has_details && index < camera_rays.size(); ++index)
        details[index] =
            ray_detail(camera_, camera_rays[index], config_.voxel_detail_px, pixel_seeds[index], sample_index);
    const std::uint32_t depth = walked != nullptr ? config_.indirect.mirror_depth : 0;
    thread_local std::vector<Follower> mirrored, following;
    mirrored.clear();
    follow({.followers = std::span(followers).first(camera_rays.size()),
            .pixel_seeds = pixel_seeds,
            .targets = targets,
            .details = std::span(details).first(has_details ? camera_rays.size() : 0)},
           0, samples, parts, data, depth > 0 ? &mirrored : nullptr, walked);
    // What the last mirrors show is not lit any more, as in Cycles: the world, and what glows.
    for (std::uint32_t mirror_count = 1; mirror_count <= depth + 1 && !mirrored.empty(); ++mirror_count) {
        const bool is_past = mirror_count > depth;
        following.swap(mirrored);
        mirrored.clear();
        for (std::size_t first = 0; first < following.size(); first += DirectLight::most_points) {
            const std::size_t count = std::min(DirectLight::most_points, following.size() - first);
            follow({.followers = std::span(following).subspan(first, count),
                    .pixel_seeds = pixel_seeds,
                    .targets = targets},
                   mirror_count, samples, parts, data, is_past ? nullptr : &mirrored, is_past ? nullptr : walked);
        }
    }
}

void ViewPath::follow(const Rays& rays, std::uint32_t mirror_count, std::span<PathSample> samples,
                      std::span<std::vector<MediumPart>> parts, const DataOfRays& data, std::vector<Follower>* mirrored,
                      SurfaceWalk* walked) const {
    constexpr std::size_t size = DirectLight::most_points;
    const bool is_in_mirror = mirror_count > 0;
    const std::span<Follower> followers = rays.followers;
    std::size_t count = followers.size();
    const bool has_details = !rays.details.empty();
    const bool has_features = !data.each.empty() && data.config->has_features();
    const bool has_data = !data.each.empty() && !is_in_mirror;
    std::array<Ray, size> next;
    std::array<RayDetail, size> details;
    std::array<Hit, size> hits;
    thread_local SurfaceWalk behind; // what lights the other sides of a layer's points
    for (std::uint32_t layer = 0; layer < max_layer_count && count > 0; ++layer) {
        behind.clear();
        for (std::size_t i = 0; i < count; ++i) {
            next[i] = followers[i].part;
            if (has_details)
                details[i] = rays.details[followers[i].index];
        }
        scene_.closest_hits(std::span(next).first(count), hits, is_in_mirror ? mirror_mask : camera_mask,
                            std::span(details).first(has_details ? count : 0));
        std::size_t going_on = 0;
        for (std::size_t i = 0; i < count; ++i) {
            Follower& follower = followers[i];
            const Hit& hit = hits[i];
            PathSample& sample = samples[follower.index];
            if (!media_.is_empty())
                pass_media(follower, hit, sample, is_in_mirror ? nullptr : &parts[follower.index]);
            if (!hit.is_hit()) {
                reach_world(follower, is_in_mirror, sample);
                if (has_features && (is_in_mirror || !config_.is_film_transparent))
                    see_world_features(follower.features, scene_.world().seen_radiance(follower.part.direction),
                                       data.each[follower.index].features);
                continue;
            }
            const Rgb throughput = follower.throughput();
            const SurfacePoint point = surface_point(scene_, follower.part, hit, rays.pixel_seeds[follower.index]);
            thread_local std::vector<Lobe> lobes;
            lobes.clear();
            Ray asking = follower.part; // transparent surfaces on its way change neither where it began, nor its length
            asking.near_m = follower.near_m;
            const float footprint_m = follower.width_m + hit.distance_m * follower.spread;
            const AskingRay asking_ray{
                .ray = asking, .kind = is_in_mirror ? RayKind::Mirror : RayKind::Camera, .footprint_m = footprint_m};
            SurfaceClosures closures = scene_.closures(asking_ray, point.shading, hit, &lobes);
            const bool was_covered = follower.has_first_surface;
            if (has_data && !was_covered && !data.config->aovs.empty())
                see_aovs(scene_, asking_ray, point.shading, hit, average(follower.through_surfaces), data.config->aovs,
                         data.each[follower.index]);
            if (!is_in_mirror) {
                const Rgb removed = cut_out(scene_.is_held_out(hit.instance), closures, lobes);
                sample.alpha -= average(throughput * removed);
                if (removed == Rgb(1.0f))
                    continue; // a hole: no pass sees anything there
            }
            show(follower, point, closures, is_in_mirror, sample);
            if (has_data) {
                PathData& of_ray = data.each[follower.index];
                see_layer(scene_, camera_, hit, point.shading.position,
                          average(throughput) * (1.0f - average(closures.transparent)),
                          follower.has_first_surface && !was_covered, *data.config, of_ray);
            }
            FeatureSearches searches;
            if (has_features)
                searches = see_features(
                    follower.features, hit.distance_m, closures,
                    {.lobes = lobes, .normal = point.shading.shading_normal, .outgoing = -follower.part.direction},
                    camera_.world_from_camera, mirrored != nullptr, data.each[follower.index].features);
            if (walked != nullptr && rays.targets[follower.index] != nowhere &&
                (closures.diffuse_albedo != Rgb(0.0f) || !lobes.empty() || config_.lights_black_surfaces ||
                 (config_.finds_ambient && !is_in_mirror && closures.transparent != Rgb(1.0f)))) {
                const Rgb albedo = closures.diffuse_albedo * std::numbers::inv_pi_v<float>;
                const Rgb seen = is_in_mirror ? Rgb(0.0f) : throughput;
                walked->points.push_back(point);
                walked->points.back().lambert_share = average(closures.diffuse_albedo);
                walked->shades.push_back(
                    {seen, throughput * albedo, seen * (1.0f - closures.transparent), rays.targets[follower.index]});
                if (!lobes.empty())
                    walked->push_lobes(lobes, -follower.part.direction, throughput);
            }
            if (!lobes.empty() && !is_in_mirror)
                sample.diffuse_colour += throughput * LobeSet{.lobes = lobes}.diffuse_colour();
            if (closures.translucent != Rgb(0.0f) && walked != nullptr && rays.targets[follower.index] != nowhere) {
                behind.points.push_back(other_side(point));
                behind.shades.push_back({Rgb(0.0f), throughput * closures.translucent * std::numbers::inv_pi_v<float>,
                                         Rgb(0.0f), rays.targets[follower.index]});
            }
            if (const Rgb weight = throughput * closures.mirrored;
                mirrored != nullptr && std::max({weight.x, weight.y, weight.z}) >= least_mirrored) {
                mirrored->push_back(follower);
                mirrored->back().part = mirrored_ray(point, follower.part);
                mirrored->back().width_m = footprint_m;
                mirrored->back().near_m = 0.0f;
                mirrored->back().through_surfaces *= closures.mirrored;
                mirrored->back().has_first_surface = true;
                mirrored->back().features = searches.mirrored;
            }
            follower.features = searches.passing;
            follower.through_surfaces *= closures.transparent;
            if (follower.through_surfaces == Rgb(0.0f))
                continue;
            // The same ray meets the same triangle at the same distance, bit for bit: one step further is behind it.
            follower.part.near_m = std::nextafter(hit.distance_m * (1.0f + 4e-7f), follower.part.far_m);
            followers[going_on++] = follower;
        }
        count = going_on;
        if (walked != nullptr)
            walked->end_batch(mirror_count * max_layer_count + layer);
        if (!behind.points.empty()) {
            walked->points.insert(walked->points.end(), behind.points.begin(), behind.points.end());
            walked->shades.insert(walked->shades.end(), behind.shades.begin(), behind.shades.end());
            walked->end_batch(mirror_count * max_layer_count + layer);
        }
    }
}

void ViewPath::ask_lights(const SurfaceWalk& walked, std::uint32_t sample_index, std::span<const std::uint8_t> is_asked,
                          SurfaceLight& light, std::size_t group_count) const {
    const std::size_t light_count = light_.light_count();
    light.lights.resize(light_count);
    light.many_by_group.resize(light_.has_many() ? group_count : 0);
    for (SurfaceLight::OfLight& of_group : light.many_by_group) {
        of_group.irradiance.resize(walked.points.size());
        of_group.reflected.resize(walked.lobed.size());
    }
    for (std::size_t index = 0; index < light_count; ++index)
        if (is_asked[index] != 0) {
            light.lights[index].irradiance.resize(walked.points.size());
            light.lights[index].unshadowed.resize(
                config_.lights_black_surfaces && !light_.is_world(index) ? walked.points.size() : 0);
            light.lights[index].reflected.resize(walked.lobed.size());
        }
    thread_local std::vector<DirectLight::Irradiance> irradiance;
    irradiance.resize(light_count * DirectLight::most_points);
    thread_local std::vector<DirectLight::Irradiance> many_by_group;
    std::size_t first = 0;
    for (const auto [end, layer] : walked.batches) {
        const std::size_t count = end - first;
        many_by_group.assign(light.many_by_group.size() * count, {});
        const std::span<const SurfaceWalk::LobedPoint> lobed = walked.lobed_of(first, end);
        const auto first_lobed = static_cast<std::size_t>(lobed.data() - walked.lobed.data());
        DirectLight::PointLobes lobes;
        for (const SurfaceWalk::LobedPoint& of : lobed)
            lobes[of.point - first] = walked.lobes_of(of);
        light_.at(std::span(walked.points).subspan(first, count), {sample_index, 1 + layer * pairs_per_layer}, is_asked,
                  irradiance, lobed.empty() ? nullptr : &lobes, many_by_group);
        for (std::size_t index = 0; index < light_count; ++index) {
            if (is_asked[index] == 0)
                continue;
            SurfaceLight::OfLight& of_light = light.lights[index];
            for (std::size_t i = 0; i < count; ++i) {
                const DirectLight::Irradiance& found = irradiance[index * count + i];
                of_light.irradiance[first + i] = found.sum();
                if (!of_light.unshadowed.empty())
                    of_light.unshadowed[first + i] = found.unshadowed;
            }
            for (std::size_t i = 0; i < lobed.size(); ++i)
                of_light.reflected[first_lobed + i] = irradiance[index * count + lobed[i].point - first].reflected;
        }
        for (std::size_t group = 0; group < light.many_by_group.size(); ++group) {
            SurfaceLight::OfLight& of_group = light.many_by_group[group];
            for (std::size_t i = 0; i < count; ++i)
                of_group.irradiance[first + i] = many_by_group[group * count + i].sum();
            for (std::size_t i = 0; i < lobed.size(); ++i)
                of_group.reflected[first_lobed + i] = many_by_group[group * count + lobed[i].point - first].reflected;
        }
        first = end;
    }
}

std::size_t ViewPath::ask_again(const SurfaceWalk& walked, std::uint32_t sample_index,
                                std::span<const std::uint8_t> is_asked, const MovedBoxes& moved,
                                SurfaceLight& light) const {
    std::array<SurfacePoint, DirectLight::most_points> again;
    std::array<std::uint32_t, DirectLight::most_points> index_of;
    std::array<DirectLight::Irradiance, DirectLight::most_points> irradiance;
    DirectLight::PointLobes lobes, lobes_again;
    std::array<std::size_t, DirectLight::most_points> lobed_index;
    std::size_t again_count = 0, first = 0;
    for (const auto [end, layer] : walked.batches) {
        const auto points = std::span(walked.points).subspan(first, end - first);
        const std::span<const SurfaceWalk::LobedPoint> lobed = walked.lobed_of(first, end);
        if (!lobed.empty())
            lobes.fill({});
        for (std::size_t i = 0; i < lobed.size(); ++i) {
            lobes[lobed[i].point - first] = walked.lobes_of(lobed[i]);
            lobed_index[lobed[i].point - first] = static_cast<std::size_t>(&lobed[i] - walked.lobed.data());
        }
        const PairIndex first_pair{sample_index, 1 + layer * pairs_per_layer};
        for (std::size_t index = 0; index < light_.light_count(); ++index) {
            if (is_asked[index] != 0)
                continue;
            std::size_t count = 0;
            for (LaneSet left = light_.may_meet(index, points, first_pair, moved, lobed.empty() ? nullptr : &lobes);
                 left != 0; left &= left - 1) {
                const auto point = static_cast<std::uint32_t>(std::countr_zero(left));
                again[count] = points[point];
                lobes_again[count] = lobed.empty() ? LobeSet{} : lobes[point];
                irradiance[count] = {};
                index_of[count++] = static_cast<std::uint32_t>(first) + point;
            }
            if (count == 0)
                continue;
            light_.add_one(index, std::span(again).first(count), first_pair, irradiance,
                           lobed.empty() ? nullptr : &lobes_again);
            SurfaceLight::OfLight& of_light = light.lights[index];
            for (std::size_t i = 0; i < count; ++i) {
                of_light.irradiance[index_of[i]] = irradiance[i].sum(); // no occluder changes what is unshadowed
                if (!lobes_again[i].lobes.empty())
                    of_light.reflected[lobed_index[index_of[i] - first]] = irradiance[i].reflected;
            }
            again_count += count;
        }
        first = end;
    }
    return again_count;
}

void ViewPath::add_light(const SurfaceWalk& walked, const SurfaceLight& light, std::span<PathSample> samples) const {
    const std::size_t lamp_count = light_.light_count() - (light_.has_world() ? 1 : 0);
    for (std::size_t point = 0; point < walked.points.size(); ++point) {
        const auto& [throughput, radiance, cover, target] = walked.shades[point];
        PathSample& sample = samples[target];
        Rgb from_lights(0.0f), unshadowed(0.0f), from_world(0.0f);
        for (std::size_t lamp = 0; lamp < lamp_count; ++lamp) {
            from_lights += light.lights[lamp].irradiance[point];
            if (!light.lights[lamp].unshadowed.empty())
                unshadowed += light.lights[lamp].unshadowed[point];
        }
        if (light_.has_world())
            from_world = light.lights.back().irradiance[point];
        sample.radiance += radiance * (from_lights + from_world);
        if (sample.world_lit.albedo == Rgb(0.0f)) {
            const ShadingPoint& shading = walked.points[point].shading;
            sample.world_lit = {shading.position, shading.shading_normal, radiance, from_world};
        }
        sample.lit += throughput * from_lights;
        sample.unshadowed += throughput * unshadowed;
    }
    for (std::size_t lobed = 0; lobed < walked.lobed.size(); ++lobed) {
        Rgb reflected(0.0f);
        for (const SurfaceLight::OfLight& of_light : light.lights)
            reflected += of_light.reflected[lobed];
        const SurfaceWalk::LobedPoint& of = walked.lobed[lobed];
        samples[walked.shades[of.point].sample].radiance += of.throughput * reflected;
    }
    if (!walked.shades.empty() && !samples[walked.shades.front().sample].by_group.empty())
        add_light_to_groups(walked, light, samples);
}
} // namespace tyndall::render
