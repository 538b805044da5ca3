// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/prepared_lights.hpp"
#include "core/parallel.hpp"
#include "light_shafts/edited_resolution.hpp"
#include "light_shafts/exact_strip.hpp"
#include "light_shafts/grid_resolution.hpp"
#include "light_shafts/light_shares.hpp"
#include "light_shafts/map_cache.hpp"
#include "light_shafts/occluder_edits.hpp"
#include "light_shafts/occluders.hpp"
#include "light_shafts/ray_outline.hpp"
#include "scene/area_light.hpp"
#include <algorithm>

namespace tyndall::light_shafts {
MediaRay clip_to_media(const Media& media, const ViewRay& ray, std::vector<MediumSegment>& segments) {
    const std::size_t first = segments.size();
    MediaRay result{.clipped = {ray.origin, ray.direction, ray.near_m, ray.near_m}};
    if (!(ray.near_m < ray.far_m))
        return result;
    media.segments({.origin = ray.origin, .direction = ray.direction, .near_m = ray.near_m, .far_m = ray.far_m},
                   segments);
    if (segments.size() == first)
        return result;
    if (MediumSegment& last = segments.back(); std::isinf(last.far_m))
        last.far_m = last.near_m + opaque_within_m(media.sigma_t_per_m(last.set));
    result.clipped.near_m = segments[first].near_m;
    result.clipped.far_m = segments.back().far_m;
    for (std::size_t segment = first; segment < segments.size(); ++segment)
        result.length_in_media_m += segments[segment].far_m - segments[segment].near_m;
    return result;
}

/// What a light sample may cost. `share_of_frame` and `share_of_light` are shares of the scattered light; a resolution
/// that the artist sets is that of a whole light.
static Config config_of_share(const Config& config, float share_of_frame, float share_of_light) {
    Config result = config;
    result.error_target = error_of_share(config.error_target, share_of_frame);
    if (config.resolution != 0)
        result.resolution = std::max(
            16u, static_cast<std::uint32_t>(static_cast<float>(config.resolution) * std::sqrt(share_of_light)));
    return result;
}

/// What this frame found in the cache.
static void count_kept(const MapCache::Counts& before, const MapCache& cache, Statistics& statistics) {
    const MapCache::Counts now = cache.counts();
    const auto count = [&](const char* what, std::size_t MapCache::Counts::*of) {
        if (now.*of > before.*of)
            statistics.count(what, static_cast<double>(now.*of - before.*of));
    };
    count("depth map: kept", &MapCache::Counts::found_maps);
    count("depth map: made", &MapCache::Counts::missed_maps);
    count("slope rows: kept", &MapCache::Counts::found_rows);
    count("slope rows: made", &MapCache::Counts::missed_rows);
    statistics.count("kept maps: bytes", static_cast<double>(cache.bytes()));
}

namespace {
/// What may stand between a light and the air; what nobody asks for is not there.
struct Blockers {
    std::shared_ptr<const Occluders> occluders;
    std::shared_ptr<const StripOnDemand> on_demand;
    std::shared_ptr<const StripScene> strip;
};
} // namespace

/// Those of `all` that block an emitter.
static Blockers blockers_of(const Scene& scene, const LightLinks& links, const Blockers& all,
                            const Progress& progress) {
    Blockers some{.occluders = nullptr, .on_demand = std::make_shared<const StripOnDemand>(scene, links), .strip = {}};
    if (all.occluders)
        some.occluders = blocking(scene, *all.occluders, links, progress);
    if (all.strip)
        some.strip = std::make_shared<const StripScene>(make_strip_scene(scene, progress, links));
    return some;
}

/// One for each light group; returns these.
static std::vector<std::uint8_t> assign_slots(const Scene& scene, std::span<LightBeams> lights) {
    std::vector<std::uint8_t> slots;
    for (LightBeams& light : lights) {
        const std::uint8_t group =
            light.light < scene.lights().size() ? scene.lights()[light.light].light_group : scene.world().light_group();
        const auto slot = std::ranges::find(slots, group);
        light.slot = static_cast<std::size_t>(slot - slots.begin());
        if (slot == slots.end())
            slots.push_back(group);
    }
    return slots;
}

static bool has_pattern(const LightSample& sample, const Light& lamp, const View& view) {
    const bool has_cone =
        sample.spot != nullptr && (sample.spot->kind == LightKind::Spot || is_narrow_area(*sample.spot));
    if (sample.is_directional || !(has_cone || (sample.textured != nullptr && lamp.kind != LightKind::Area)))
        return false;
    constexpr float wide_px = 8.0f; // twice the width over which pixels share
    const float radius_m =
        lamp.kind == LightKind::Area ? std::min(lamp.half_size_m.x, lamp.half_size_m.y) : lamp.radius_m;
    const float pixel_m = view.spacing * (view.is_orthographic ? 1.0f : glm::distance(view.position, lamp.position));
    return 2.0f * radius_m < wide_px * pixel_m;
}

void PreparedLights::prepare(const Scene& scene, const View& view, std::span<const ViewRay> clipped,
                             std::vector<ScatteringLight> lights_to_prepare, const Config& config, Progress& progress) {
    LightShares shares(media, clipped);
    for (ScatteringLight& light : lights_to_prepare) {
        LightBeams beams{.light = light.index, .beams = {}, .parts = light.parts, .dealt_share = light.dealt_share};
        if (light.index < scene.lights().size()) {
            const Light& lamp = scene.lights()[light.index];
            beams.lamp_position = lamp.position;
            beams.unlit_media = lamp.unlit_media;
            if (light.samples.size() > 1 && LampInside::shines_in(lamp))
                beams.inside.emplace(lamp, config.attenuates_light && lamp.is_dimmed_by_media());
        }
        for (std::size_t index = 0; index < light.samples.size(); ++index) {
            progress.poll();
            Beam beam;
            LightSample& sample = beam.sample = light.samples[index];
            sample.is_dimmed_by_media &= config.attenuates_light;
            if (!light.cells.empty())
                beam.cell = &light.cells[index];
            if (sample.is_directional)
                beam.directional.emplace(media, sample);
            else
                beam.local.emplace(media, sample);
            // Where media only absorb, to walk them for shares of nothing would take most of a frame.
            if (sample.is_directional ? beam.directional->is_black() : beam.local->is_black())
                continue;
            if (sample.is_directional)
                shares.add(*beam.directional);
            else
                shares.add(*beam.local);
            beam.share = shares.size() - 1;
            beams.beams.push_back(std::move(beam));
        }
        if (beams.beams.empty()) {
            statistics.skip("light shafts of " + light.name, "no medium scatters its light");
        } else {
            const LightSample& first = beams.beams.front().sample;
            const Light* textured = first.textured;
            beams.has_pattern =
                light.index < scene.lights().size() && has_pattern(first, scene.lights()[light.index], view);
            if (textured != nullptr && textured->texture->projection == LightProjection::Planar)
                beams.texture_rows = std::make_shared<const TextureRows>(*textured, view, clipped);
            lights.push_back(std::move(beams));
        }
        disc_cells.push_back(std::move(light.cells)); // the samples' pointers into it stay
    }
    if (config.keeps_groups_apart)
        slots = assign_slots(scene, lights);
    struct BeamToPrepare {
        Beam* beam;
        float share_of_light, dealt_share;
        const OccluderEdits* edits;
        const Blockers* blockers;
        float error_target = 0.0f; ///< Of all of an edited light's samples; 0: as its share says.
    };
    std::vector<BeamToPrepare> all_beams;
    std::vector<std::unique_ptr<const OccluderEdits>> edits;
    std::shared_ptr<const StripScene> strip;
    std::shared_ptr<const Occluders> occluders; // nothing where nobody asks for them
    const auto strip_on_demand = std::make_shared<const StripOnDemand>(scene);
    std::vector<RaySpan> outer_rays;
    if (lights.empty())
        return;
    const auto is_edited = [&](const LightBeams& light) {
        return light.light < scene.lights().size() && !scene.lights()[light.light].occluder_edits.empty();
    };
    if (config.method == Method::Exact) {
        const StageTimer timer(statistics, "light shafts: hierarchies for cuts");
        strip = std::make_shared<const StripScene>(make_strip_scene(scene, progress));
    }
    if (config.method != Method::Exact || std::ranges::any_of(lights, is_edited)) {
        occluders = config.kept_maps
                        ? config.kept_maps->occluders_of(scene, progress)
                        : std::make_shared<const Occluders>(gather_occluders(scene.description(), progress));
        outer_rays = outline(view.is_orthographic, clipped, progress);
    }
    std::vector<std::unique_ptr<const Blockers>> blockers;
    blockers.push_back(std::make_unique<const Blockers>(Blockers{occluders, strip_on_demand, strip}));
    for (LightBeams& light : lights) {
        const OccluderEdits* of_light = nullptr;
        const Blockers* blocked_by = blockers.front().get();
        if (light.light < scene.lights().size() && !scene.lights()[light.light].links.is_blocked_by_all()) {
            blockers.push_back(std::make_unique<const Blockers>(
                blockers_of(scene, scene.lights()[light.light].links, *blockers.front(), progress)));
            blocked_by = blockers.back().get();
        }
        if (is_edited(light)) {
            edits.push_back(std::make_unique<const OccluderEdits>(scene.description(), scene.lights()[light.light],
                                                                  *blocked_by->occluders));
            of_light = edits.back()->is_empty() ? nullptr : edits.back().get();
        }
        for (Beam& beam : light.beams)
            all_beams.push_back({&beam, light.dealt_share / static_cast<float>(light.beams.size()), light.dealt_share,
                                 of_light, blocked_by});
    }
    // Of a series all pictures' errors average out, as all strata's of one picture do.
    const auto config_of = [&](const BeamToPrepare& of) {
        return config_of_share(config, of.dealt_share * shares.share(of.beam->share), of.share_of_light);
    };
    tracks_ratios = config.grid_method == GridMethod::RatioTracking;
    seed = config.seed;
    if (!grid_loss && !media.grids().is_empty() && !tracks_ratios) {
        const StageTimer timer(statistics, "light shafts: resolution in grids");
        const GridResolution resolution = choose_grid_resolution(media, clipped, lights, shares, config, progress);
        step_limits = resolution.step_limits;
        grid_loss = resolution.loss;
        statistics.count("light shafts in grids: voxels per step", step_limits.length_voxels);
        statistics.count("light shafts in grids: voxels per light column", grid_loss->spacing_voxels);
        statistics.count("light shafts in grids: error of steps", resolution.step_error);
        statistics.count("light shafts in grids: error of light columns", resolution.loss_error);
    }
    if (config.kept_maps)
        config.kept_maps->begin_picture();
    const MapCache::Counts before = config.kept_maps ? config.kept_maps->counts() : MapCache::Counts{};
    progress.set_message("Light shafts: " + std::to_string(all_beams.size()) + " light samples");
    const auto with_outline = [&](const Beam& beam, const auto& use) {
        if (beam.cell == nullptr)
            return use(std::span<const RaySpan>(outer_rays));
        const std::vector<RaySpan> in_cell = clip_to_cell(outer_rays, beam.cell->directions, beam.cell->reach_m);
        return use(std::span(in_cell));
    };
    const auto make_edited = [&](const BeamToPrepare& of, const Config& how, EditedMap map) {
        return with_outline(*of.beam, [&](std::span<const RaySpan> rays) {
            return make_edited_beam(scene, *of.edits, *of.blockers->occluders, view, of.beam->sample, rays,
                                    of.blockers->on_demand, how, progress, map);
        });
    };
    for (std::size_t index = 0; config.resolution == 0 && index < all_beams.size(); ++index) {
        BeamToPrepare& of = all_beams[index];
        if (of.edits == nullptr)
            continue;
        if (index > 0 && all_beams[index - 1].edits == of.edits) { // one sample tells of its light
            of.error_target = all_beams[index - 1].error_target;
            continue;
        }
        const StageTimer timer(statistics, "occluder edits: resolution");
        Config asked = config_of(of);
        of.error_target =
            measured_error_target(*this, *of.beam, clipped, asked.error_target, [&](std::uint32_t texels) {
                asked.resolution = texels;
                return make_edited(of, asked, EditedMap::AsAsked);
            });
    }
    parallel_for(
        all_beams.size(), progress,
        [&](std::size_t index) {
            const BeamToPrepare& of = all_beams[index];
            Beam& beam = *of.beam;
            beam.dim_by_grids(grid_loss.value_or(GridLoss()));
            if (config.method == Method::Exact && of.edits == nullptr) {
                beam.visibility = make_exact_strip(scene, beam.sample, of.blockers->strip);
                return;
            }
            Config share = config_of(of);
            if (of.edits != nullptr) {
                share.error_target = std::max(share.error_target, of.error_target);
                beam.visibility = make_edited(of, share, EditedMap::ShowsEdits);
                return;
            }
            MakeBeamVisibility& make = config.method == Method::Epipolar ? make_epipolar_beam : make_shadow_map_beam;
            beam.visibility = with_outline(beam, [&](std::span<const RaySpan> rays) {
                return make(scene, *of.blockers->occluders, view, beam.sample, rays, of.blockers->on_demand, share,
                            progress);
            });
        },
        1);
    float most = -1.0f;
    for (const LightBeams& light : lights) {
        for (const Beam& beam : light.beams)
            if (shares.share(beam.share) > most) {
                most = shares.share(beam.share);
                finest = beam.visibility.get();
            }
        statistics.append(light.beams.front().visibility->statistics()); // one tells of its light; a world has many
    }
    statistics.count("light shafts: light samples", static_cast<double>(all_beams.size()));
    if (config.kept_maps)
        count_kept(before, *config.kept_maps, statistics);
}
} // namespace tyndall::light_shafts
