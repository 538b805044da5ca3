// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/view_path.hpp"
#include "render/follower.hpp"
#include "render/passed_surface.hpp"
#include "render/pixel_footprint.hpp"
#include "render/sent_rays.hpp"
#include "scene/seen_part.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numbers>
#include <optional>

namespace tyndall::render {
// Blender's default: a surface that covers less does not show in Depth, Normal and Position.

/// Seeds and targets as walk() has them.
struct ViewPath::Rays {
    std::span<Follower> followers;
    std::span<const Ray> camera_rays;
    std::span<const std::uint32_t> pixel_seeds, targets;
    std::uint32_t sample_index = 0;
    std::uint32_t generation = 0;            ///< How often each was sent on.
    std::span<const RayDetail> details = {}; ///< By the index of a camera ray; empty where every cell is met.
    Among among = Among::All;                ///< What they meet.
};

std::optional<float> ViewPath::goes_on_at(const Follower& follower, const Ray& camera_ray) {
    constexpr float least_cosine = 1.0f - 5e-5f; // 0.01 rad
    if (follower.kind == RayKind::Camera)
        return 0.0f;
    if (follower.mirror_count > 0 || glm::dot(follower.part.direction, camera_ray.direction) < least_cosine)
        return std::nullopt;
    return glm::dot(follower.part.origin - camera_ray.origin, camera_ray.direction);
}

void ViewPath::pass_media(Follower& follower, const Hit& hit, const Ray& camera_ray, PathSample& sample,
                          std::vector<MediumPart>& parts) const {
    const Ray inside = seen_part(media_, follower.part, hit);
    const Rgb in_front = follower.throughput();
    if (config_.collects_parts)
        if (const std::optional<float> before_m = goes_on_at(follower, camera_ray))
            parts.push_back(
                {.near_m = *before_m + inside.near_m, .far_m = *before_m + inside.far_m, .weight = in_front});
    const Rgb emission = in_front * media_.emission(inside);
    sample.add_light(emission, LightOf::Picture, follower.way_of_shine());
    if (follower.kind == RayKind::Camera)
        sample.emission += emission;
    follower.through_media *= media_.transmittance(inside);
    if (!follower.has_first_surface)
        sample.transmittance = follower.through_media;
}

void ViewPath::reach_world(const Follower& follower, bool is_sent_on, PathSample& sample) const {
    const bool is_seen_through = config_.is_film_transparent && !is_sent_on;
    if (is_seen_through)
        sample.alpha -= average(follower.throughput());
    if (is_seen_through && sample.paths == nullptr)
        return;
    const Rgb seen = follower.throughput() * scene_.world().seen_radiance(follower.part.direction, follower.kind);
    if (!is_seen_through)
        sample.add_light(seen, scene_.world().light_group(), follower.of, follower.way_of_shine());
    if (sample.paths != nullptr && !is_sent_on)
        sample.paths->environment += seen; // of a transparent film, too, as in Cycles
}

/// A catcher takes the place of what lies behind it: of the world, if the film shows it, by the share that its shadow leaves.
void ViewPath::catch_shadow(const Follower& follower, const SurfaceClosures& closures, PathSample& sample) const {
    const Rgb covered = follower.through_surfaces * (1.0f - closures.transparent);
    CaughtLight& caught = *sample.caught;
    sample.alpha -= average(covered);
    caught.weight += average(covered);
    caught.alone += follower.through_surfaces * closures.emission;
    if (!config_.is_film_transparent)
        caught.backdrop += covered * scene_.world().seen_radiance(follower.part.direction);
}

void ViewPath::show(Follower& follower, const SurfacePoint& point, const SurfaceClosures& closures, bool is_sent_on,
                    LightOf of, PathSample& sample) const {
    const Rgb throughput = follower.throughput();
    if (closures.emission != Rgb(0.0f))
        sample.add_light(throughput * closures.emission,
                         sample.by_group.empty() ? no_light_group : scene_.object_info(point.hit.instance).light_group,
                         of, follower.way_of_shine());
    if (is_sent_on)
        return;
    const float threshold = config_.pass_alpha_threshold;
    if (!follower.has_first_surface && (threshold == 0.0f || 1.0f - average(closures.transparent) >= threshold)) {
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

/// As the passes have it: what comes from below is as what the surface scatters itself.
static SurfaceClosures with_below(SurfaceClosures closures, std::span<const Lobe> below) {
    for (const Lobe& lobe : below)
        closures.diffuse_albedo += lobe.weight;
    return closures;
}

void ViewPath::walk(std::span<const Ray> camera_rays, std::span<const std::uint32_t> pixel_seeds,
                    std::uint32_t sample_index, std::span<const std::uint32_t> targets, std::span<PathSample> samples,
                    std::span<std::vector<MediumPart>> parts, SurfaceWalk* walked, const DataOfRays& data) const {
    std::array<Follower, DirectLight::most_points> followers;
    std::size_t follower_count = 0;
    for (std::size_t index = 0; index < camera_rays.size(); ++index) {
        const std::span<Rgb> by_group = samples[index].by_group;
        CaughtLight* const caught = samples[index].caught;
        LightPaths* const paths = samples[index].paths;
        samples[index] = {};
        samples[index].by_group = by_group;
        samples[index].caught = caught;
        samples[index].paths = paths;
        if (caught != nullptr)
            *caught = {};
        if (paths != nullptr)
            *paths = {};
        if (!camera_rays[index].exists())
            continue; // black and opaque beside a fisheye's circle, whatever the film, as in Cycles
        Follower& follower = followers[follower_count++];
        follower.index = index;
        follower.part = camera_rays[index];
        const PixelFootprint footprint = pixel_footprint(camera_, camera_rays[index].direction);
        follower.spread = footprint.spread;
        follower.near_m = camera_rays[index].near_m;
        follower.width_m = footprint.width_m;
        follower.features.passed_m = camera_rays[index].near_m;
    }
    std::array<RayDetail, DirectLight::most_points> details; // of camera rays; what mirrors show is met cell by cell
    const bool has_details = config_.voxel_detail_px > 0.0f;
    for (std::size_t index = 0; has_details && index < camera_rays.size(); ++index)
        details[index] =
            ray_detail(camera_, camera_rays[index], config_.voxel_detail_px, pixel_seeds[index], sample_index);
    const bool sends = walked != nullptr && config_.indirect.follows_rays();
    thread_local std::vector<Follower> sent, following;
    sent.clear();
    follow({.followers = std::span(followers).first(follower_count),
            .camera_rays = camera_rays,
            .pixel_seeds = pixel_seeds,
            .targets = targets,
            .sample_index = sample_index,
            .details = std::span(details).first(has_details ? camera_rays.size() : 0)},
           samples, parts, data, sends ? &sent : nullptr, walked);
    // What is past the last mirror or bend is not lit any more, as in Cycles: the world shows, and what glows.
    for (std::uint32_t generation = 1; !sent.empty(); ++generation) {
        following.swap(sent);
        sent.clear();
        if (!std::ranges::is_sorted(following, {}, &Follower::company))
            std::ranges::stable_sort(following, {}, &Follower::company);
        for (std::span<Follower> left = following; !left.empty();) {
            const bool is_past = left.front().is_past;
            const auto others = std::ranges::find_if(
                left, [now = left.front().company()](const Follower& other) { return other.company() != now; });
            const std::size_t count =
                std::min(DirectLight::most_points, static_cast<std::size_t>(others - left.begin()));
            follow({.followers = left.first(count),
                    .camera_rays = camera_rays,
                    .pixel_seeds = pixel_seeds,
                    .targets = targets,
                    .sample_index = sample_index,
                    .generation = generation,
                    .among = left.front().of == LightOf::CatcherAlone ? Among::Catchers : Among::All},
                   samples, parts, data, is_past ? nullptr : &sent, is_past ? nullptr : walked);
            left = left.subspan(count);
        }
    }
}

/// Whether lobes wait apart: what is seen in a mirror is all what the mirror sends on.
static bool tells_apart(const ViewPathConfig& config, Scatterer first) {
    return config.tells_paths && first == Scatterer::None;
}

void ViewPath::await_lobes(const Lit& lit, const Share& share, const SurfacePoint& point, std::span<const Lobe> lobes,
                           SurfaceWalk& walked, SurfaceWalk& apart) const {
    if (lobes.empty())
        return;
    if (!tells_apart(config_, share.first)) {
        walked.push_lobes(lobes, lit.towards_viewer, share.throughput);
        return;
    }
    thread_local std::vector<Lobe> alike;
    for (const Scatterer by : {Scatterer::Diffuse, Scatterer::Glossy, Scatterer::Transmission}) {
        alike.clear();
        std::ranges::copy_if(lobes, std::back_inserter(alike),
                             [by](const Lobe& lobe) { return scatterer_of(lobe) == by; });
        if (alike.empty())
            continue;
        SurfaceWalk& to = by == Scatterer::Diffuse ? walked : apart;
        if (by != Scatterer::Diffuse) {
            apart.points.push_back(point);
            apart.points.back().lambert_share = 0.0f;
            apart.shades.push_back({Rgb(0.0f), Rgb(0.0f), Rgb(0.0f), share.sample, share.of, true, {by}});
        }
        to.push_lobes(alike, lit.towards_viewer, share.throughput);
    }
}

void ViewPath::await_light(const Lit& lit, const Share& share, SurfaceWalk& walked, Hidden& hidden) const {
    if (!lit.below.empty())
        await_exits(lit, share, hidden.exits);
    SurfaceWalk& behind = hidden.behind;
    const SurfaceClosures& closures = lit.closures;
    const bool has_fibres = std::ranges::any_of(lit.lobes, &Lobe::is_of_fibre); // which light meets from all around
    constexpr float per_irradiance = std::numbers::inv_pi_v<float>;
    const bool has_lobes =
        tells_apart(config_, share.first) ? std::ranges::any_of(lit.lobes, &Lobe::is_matte) : !lit.lobes.empty();
    if (closures.diffuse_albedo != Rgb(0.0f) || has_lobes || config_.lights_black_surfaces ||
        (config_.finds_ambient && !lit.is_unseen && closures.transparent != Rgb(1.0f))) {
        const Rgb seen = lit.is_unseen ? Rgb(0.0f) : share.throughput;
        walked.points.push_back(lit.point);
        walked.points.back().lambert_share = average(closures.diffuse_albedo);
        walked.shades.push_back({seen, share.throughput * (closures.diffuse_albedo * per_irradiance),
                                 seen * (1.0f - closures.transparent), share.sample, share.of, false,
                                 share.way(Scatterer::Diffuse)});
    }
    await_lobes(lit, share, lit.point, lit.lobes, walked, hidden.exits);
    if (closures.translucent == Rgb(0.0f) && !has_fibres)
        return;
    behind.points.push_back(other_side(scene_, lit.point));
    behind.shades.push_back({Rgb(0.0f), share.throughput * closures.translucent * per_irradiance, Rgb(0.0f),
                             share.sample, share.of, false, share.way(Scatterer::Diffuse)});
    if (!has_fibres)
        return;
    thread_local std::vector<Lobe> fibres;
    fibres.clear();
    std::ranges::copy_if(lit.lobes, std::back_inserter(fibres), &Lobe::is_of_fibre);
    behind.points.back().lambert_share = average(closures.translucent);
    await_lobes(lit, share, behind.points.back(), fibres, behind, hidden.exits);
}

void ViewPath::follow(const Rays& rays, std::span<PathSample> samples, std::span<std::vector<MediumPart>> parts,
                      const DataOfRays& data, std::vector<Follower>* sent, SurfaceWalk* walked) const {
    constexpr std::size_t size = DirectLight::most_points;
    const bool is_sent_on = rays.generation > 0;
    const std::span<Follower> followers = rays.followers;
    const RayKind kind = followers.empty() ? RayKind::Camera : followers.front().kind;
    std::size_t count = followers.size();
    const bool has_details = !rays.details.empty();
    const bool has_features = !data.each.empty() && data.config->has_features() && rays.among == Among::All;
    const bool has_data = !data.each.empty() && !is_sent_on;
    std::array<Ray, size> next;
    std::array<RayDetail, size> details;
    std::array<Hit, size> hits;
    thread_local Beside beside;
    for (std::uint32_t layer = 0; layer < max_layer_count && count > 0; ++layer) {
        beside.clear();
        for (std::size_t i = 0; i < count; ++i) {
            next[i] = followers[i].part;
            if (has_details)
                details[i] = rays.details[followers[i].index];
        }
        scene_.closest_hits(std::span(next).first(count), hits, mask_among(rays.among, seen_mask(kind)),
                            std::span(details).first(has_details ? count : 0));
        std::size_t going_on = 0;
        for (std::size_t i = 0; i < count; ++i) {
            Follower& follower = followers[i];
            const Hit& hit = hits[i];
            PathSample& sample = samples[follower.index];
            if (is_sent_on && config_.indirect.refraction_depth > 0 && rays.among == Among::All)
                see_lamps(follower, hit.is_hit() ? hit.distance_m : follower.part.far_m, sample);
            if (sent_air_ != nullptr && is_sent_on && !follower.is_past && rays.among == Among::All &&
                !goes_on_at(follower, rays.camera_rays[follower.index]))
                see_air(follower, hit.is_hit() ? hit.distance_m : follower.part.far_m,
                        hash(rays.pixel_seeds[follower.index], follower.way, layer), rays.sample_index, sample);
            if (!media_.is_empty() && rays.among == Among::All)
                pass_media(follower, hit, rays.camera_rays[follower.index], sample, parts[follower.index]);
            if (!hit.is_hit()) {
                reach_world(follower, is_sent_on, sample);
                if (has_features && (is_sent_on || !config_.is_film_transparent))
                    see_world_features(follower.features,
                                       scene_.world().seen_radiance(follower.part.direction, follower.kind),
                                       data.each[follower.index].features);
                continue;
            }
            const Rgb throughput = follower.throughput();
            const SurfacePoint point = surface_point(scene_, follower.part, hit, rays.pixel_seeds[follower.index]);
            thread_local std::vector<Lobe> lobes, bent, below;
            lobes.clear(), bent.clear(), below.clear();
            Ray asking = follower.part; // transparent surfaces on its way change neither where it began, nor its length
            asking.near_m = follower.near_m;
            const float footprint_m = follower.width_m + hit.distance_m * follower.spread;
            const AskingRay asking_ray{.ray = asking,
                                       .kind = kind,
                                       .footprint_m = footprint_m,
                                       .random = ProgramRandom{point.pixel_seed, rays.sample_index}};
            SurfaceClosures closures = scene_.closures(asking_ray, point.shading, hit, &lobes);
            const bool was_covered = follower.has_first_surface;
            if (has_data && !was_covered && !data.config->aovs.empty())
                see_aovs(scene_, asking_ray, point.shading, hit, follower.samples, data.config->aovs,
                         data.each[follower.index]);
            if (!is_sent_on) {
                const Rgb removed = cut_out(scene_.is_held_out(hit.instance), closures, lobes);
                sample.alpha -= average(throughput * removed);
                if (removed == Rgb(1.0f))
                    continue; // a hole: no pass sees anything there
            }
            take_apart(lobes, bent, below);
            const bool is_caught = !is_sent_on && sample.caught != nullptr && scene_.catches_shadows(hit.instance);
            const LightOf of = is_caught ? LightOf::CatcherAmongAll : follower.of;
            std::optional<SurfaceClosures> with;
            const SurfaceClosures& seen = below.empty() ? closures : with.emplace(with_below(closures, below));
            show(follower, point, seen, is_sent_on, of, sample);
            if (is_caught)
                catch_shadow(follower, closures, sample);
            if (has_data) {
                PathData& of_ray = data.each[follower.index];
                see_layer(scene_, camera_, hit, point.shading.position,
                          average(throughput) * (1.0f - average(closures.transparent)),
                          follower.has_first_surface && !was_covered, *data.config, of_ray);
            }
            const LobeSet lobe_set{
                .lobes = lobes, .normal = point.shading.shading_normal, .outgoing = -follower.part.direction};
            FeatureSearches searches;
            if (has_features)
                searches = see_features(follower.features, hit.distance_m, seen, lobe_set, bent,
                                        camera_.world_from_camera, sent != nullptr, data.each[follower.index].features);
            if (walked != nullptr && rays.targets[follower.index] != nowhere) {
                const Lit lit{point,
                              closures,
                              lobes,
                              below,
                              -follower.part.direction,
                              is_sent_on || is_caught,
                              footprint_m,
                              {hash(point.pixel_seed, follower.way, layer), rays.sample_index}};
                const auto target = static_cast<std::uint16_t>(rays.targets[follower.index]);
                await_light(lit, {throughput, target, of, follower.first}, *walked, beside.among_all);
                if (is_caught) // media dim what it is divided by no more than the world behind
                    await_light(lit, {follower.through_surfaces, target, LightOf::CatcherAlone, follower.first},
                                beside.alone, beside.hidden_alone);
            }
            if (!lobes.empty() && !is_sent_on)
                sample.diffuse_colour += throughput * lobe_set.diffuse_colour();
            if (sample.paths != nullptr && !is_sent_on)
                see_colours(closures, lobe_set, bent, throughput, *sample.paths);
            if (sent != nullptr) {
                follower.gain *= gain_of(closures, bent);
                Sending sending{follower,
                                point,
                                footprint_m,
                                searches,
                                follower.through_media,
                                of,
                                follower.gain,
                                rays.pixel_seeds[follower.index],
                                rays.sample_index};
                send_on(sending, closures, bent, *sent);
                sending.through_media = Rgb(1.0f);
                sending.of = LightOf::CatcherAlone;
                if (is_caught)
                    send_on(sending, closures, bent, *sent);
            }
            follower.features = searches.passing;
            if (has_data)
                follower.samples *= share_going_on(seen, lobes, bent);
            follower.through_surfaces = left_behind(follower.through_surfaces, closures.transparent);
            if (follower.through_surfaces == Rgb(0.0f))
                continue;
            go_on_behind(follower.part, hit);
            followers[going_on++] = follower;
        }
        count = going_on;
        if (walked == nullptr)
            continue;
        const std::uint32_t place = rays.generation * max_layer_count + layer;
        walked->end_batch(place, rays.among);
        walked->append_batch(beside.among_all.behind, place, rays.among);
        walked->append_batch(beside.among_all.exits, place, rays.among, size);
        walked->append_batch(beside.alone, place, Among::Catchers);
        walked->append_batch(beside.hidden_alone.behind, place, Among::Catchers);
        walked->append_batch(beside.hidden_alone.exits, place, Among::Catchers, size);
    }
}
} // namespace tyndall::render
