// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/frame_surfaces.hpp"
#include "render/frame_shafts.hpp"
#include "render/pixel_noise.hpp"
#include "shading/lobes/lobe_models.hpp"
#include <algorithm>
#include <numeric>

namespace tyndall::render {
FrameSurfaces::FrameSurfaces(const Scene& scene, const Media& media, const Camera& camera, const Region& region,
                             const FrameConfig& config, Statistics& statistics, Progress& progress)
    : scene_(scene), media_(media), camera_(camera), region_(region), config_(config), statistics_(statistics),
      progress_(progress), filter_(config.pixel_filter, config.filter_width_px),
      light_(scene, media, statistics, config.indirect, config.kept_light_trees.get(), progress),
      indirect_(scene, media, light_, config.indirect, config.passes.has(Pass::AmbientOcclusion)) {
    if (config.indirect.has_ambient_occlusion && !light_.has_world())
        statistics.skip("ambient occlusion", "the world is black");
    if (config.indirect.has_bounce && !indirect_.sees_surfaces())
        statistics.skip("colour bleeding", "nothing shines");
    follows_mirrors_ = find_mirrors();
    if (follows_mirrors_ && !media.is_empty()) {
        sent_air_.emplace(scene, media, light_.emitters(),
                          SentAir::Config{config.shafts.attenuates_light, config.shafts.world_samples > 0},
                          config.kept_light_trees.get());
        if (sent_air_->is_empty())
            sent_air_.reset();
    }
    has_lobes_ = std::ranges::any_of(scene.description().materials,
                                     [](const Material& material) { return !material.lobe_sources.empty(); });
    if (config.kept_surfaces)
        config.kept_surfaces->begin_picture(scene);
    has_detail_ = config.voxel_detail_px > 0.0f && !scene.description().placed_shapes.empty();
    if (has_detail_) {
        const StageTimer timer(statistics, "voxels: what cubes cover");
        scene.prepare_detail(progress);
    }
    set_shadow_rays();
}

ViewPath FrameSurfaces::view_path(bool collects_parts) const {
    return {scene_,
            media_,
            light_,
            camera_,
            {.is_film_transparent = config_.is_film_transparent,
             .collects_parts = collects_parts,
             .lights_black_surfaces = config_.passes.has(Pass::Shadow),
             .finds_ambient = config_.passes.has(Pass::AmbientOcclusion),
             .tells_paths = config_.passes.tells_paths(),
             .pass_alpha_threshold = config_.pass_alpha_threshold,
             .indirect = config_.indirect,
             .voxel_detail_px = has_detail_ ? config_.voxel_detail_px : 0.0f},
            sent_air_ ? &*sent_air_ : nullptr};
}

SurfaceKey FrameSurfaces::key(std::uint32_t sample_index, bool collects_parts) const {
    return {.geometry = scene_.geometry(),
            .world = scene_.world(),
            .camera = camera_,
            .region = region_,
            .filter = config_.pixel_filter,
            .filter_width_px = config_.filter_width_px,
            .is_filtered = config_.pixel_samples > 1,
            .seed = config_.seed,
            .sample_index = sample_index,
            .path = view_path(collects_parts).config(),
            .bounce_rays = indirect_.bounce_rays(),
            .parts = PackedSamples::parts_for(config_.passes, world_reach_px_ > 0)};
}

/// Samples among which lights may take turns: each is asked four times or more, and as often in every round after which
/// pixels may stop.
static std::uint32_t longest_turn(const FrameConfig& config) {
    constexpr std::uint32_t longest = 4, least_asked = 4;
    const std::uint32_t samples = config.taken_samples();
    const bool has_rounds = config.noise_threshold > 0.0f;
    // Noise is told from turns, of which a round has to have several.
    const std::uint32_t within = has_rounds ? samples_per_round(samples) : samples;
    std::uint32_t turn = config.lights_take_turns ? (has_rounds ? longest / 2 : longest) : 1;
    while (turn > 1 && (within % turn != 0 || least_asked * turn > samples))
        turn /= 2;
    return turn;
}

/// How many shadow rays a light gets per surface point, and how far neighbours share those of the world.
void FrameSurfaces::set_shadow_rays() {
    const bool may_share = shares_strata(config_.shafts) && shared_reach_px(config_.pixel_samples) > 0;
    const std::vector<std::uint32_t> ones(light_.light_count(), 1);
    ShadowRayCounts counts{.of_light = ones, .turn_of_light = ones};
    const IndirectLight* bounce = indirect_.has_bounce() && config_.indirect.bounce_samples == 0 ? &indirect_ : nullptr;
    if (config_.adapts_shadow_rays) {
        CountsKey key{.surfaces = this->key(0, false),
                      .lights = {scene_.lights().begin(), scene_.lights().end()},
                      .may_share_world = may_share,
                      .attenuates_light = config_.shafts.attenuates_light,
                      .world_scatters = config_.shafts.world_samples > 0,
                      .longest_turn = longest_turn(config_),
                      .pixel_samples = std::max(config_.pixel_samples, few_samples), // fewer change nothing
                      .grid_method = config_.shafts.grid_method,
                      .grid_error_target = config_.shafts.grid_error_target,
                      .shafts_seed = config_.shafts.seed,
                      .edited_shadows = edited_shadows(scene_.lights())};
        const ShadowRayCounts* kept = config_.kept_surfaces ? config_.kept_surfaces->find_counts(key) : nullptr;
        if (kept == nullptr)
            light_.prepare_edits(std::vector<std::uint8_t>(light_.light_count(), 1), camera_, config_.shafts,
                                 statistics_, progress_);
        counts =
            kept != nullptr
                ? *kept
                : count_shadow_rays(scene_, media_, light_, bounce, camera_, filter_,
                                    {.may_share_world = may_share,
                                     .voxel_detail_px = view_path().config().voxel_detail_px,
                                     .longest_turn = longest_turn(config_),
                                     .pixel_samples = config_.pixel_samples,
                                     .seed = config_.seed,
                                     .has_fog_glow = !media_.is_empty() && (!emitters().is_empty() || media_.emits())},
                                    config_.shafts, progress_);
        if (config_.kept_surfaces && kept == nullptr)
            config_.kept_surfaces->keep_counts(std::move(key), counts);
    }
    statistics_.count("direct light: shadow rays per surface point",
                      std::transform_reduce(counts.of_light.begin(), counts.of_light.end(),
                                            counts.turn_of_light.begin(), 0.0, std::plus<>(),
                                            [](double rays, double turn) { return rays / turn; }));
    if (!counts.turn_of_light.empty())
        turn_samples_ = *std::ranges::max_element(counts.turn_of_light);
    if (counts.is_world_shared)
        world_reach_px_ = shared_reach_px(std::uint64_t{counts.of_light.back()} * config_.pixel_samples);
    pilot_ = std::move(counts.pilot);
    light_.set_ray_counts(std::move(counts.of_light));
    light_.set_turns(std::move(counts.turn_of_light));
    indirect_.set_bounce_rays(bounce != nullptr ? counts.of_bounce : std::max(config_.indirect.bounce_samples, 1u));
    if (indirect_.has_bounce())
        statistics_.count(indirect_.sees_surfaces() ? "colour bleeding: rays per surface point"
                                                    : "media that glow: rays per surface point",
                          indirect_.bounce_rays());
}

std::optional<light_shafts::SurfaceShadows::Config> FrameSurfaces::edited_shadows(std::span<const Light> lights) const {
    if (std::ranges::none_of(lights, light_shafts::SurfaceShadows::are_cast_by))
        return std::nullopt;
    return light_shafts::SurfaceShadows::config_of(camera_, config_.shafts);
}

std::vector<KeptLight> FrameSurfaces::lights_now() const {
    std::vector<KeptLight> lights;
    for (std::size_t light = 0; light < light_.light_count(); ++light) {
        KeptLight now;
        now.ray_count = light_.ray_count(light);
        now.turn = light_.turn(light);
        if (light_.is_many(light)) {
            for (const std::uint32_t lamp : light_.many_lamps())
                now.many.push_back(scene_.lights()[lamp]);
        } else if (!light_.is_world(light)) {
            now.light = scene_.lights()[light_.index_of(light)];
            now.edited_shadows = edited_shadows({&now.light, 1});
        }
        lights.push_back(std::move(now));
    }
    return lights;
}

std::optional<MovedView> FrameSurfaces::moved_since(const KeptPass& kept) const {
    MovedBoxes boxes(scene_, kept.stood_at, camera_.position());
    if (boxes.is_empty())
        return std::nullopt;
    return MovedView(std::move(boxes), camera_, config_.pixel_samples > 1 ? filter_.radius_px() : 0.0f);
}

bool FrameSurfaces::find_mirrors() const {
    const IndirectConfig& indirect = config_.indirect;
    bool has_mirrors = false, has_glass = false;
    for (const Material& material : scene_.description().materials) {
        has_mirrors |= material.gloss.has_value();
        if (std::ranges::any_of(material.lobe_sources, bends_rays, &LobeSource::model)) {
            has_glass = true;
            if (indirect.refraction_depth == 0)
                statistics_.report("Material \"" + material.name +
                                   "\" bends light, but refraction is not followed: "
                                   "what it would show is black");
        }
        if (material.gloss && indirect.mirror_depth == 0)
            statistics_.report("Material \"" + material.name +
                               "\" is a mirror, but mirrors are not followed: "
                               "what it would show is black");
    }
    const bool follows_mirrors = has_mirrors && indirect.mirror_depth > 0;
    const bool follows_bends = has_glass && indirect.refraction_depth > 0;
    if (!has_mirrors && indirect.mirror_depth > 0)
        statistics_.skip("mirrors", "no surface is one");
    if (!has_glass && indirect.refraction_depth > 0)
        statistics_.skip("refraction", "no surface bends light");
    return follows_mirrors || follows_bends;
}

SurfaceForm FrameSurfaces::form_for_pass() const {
    const SurfaceForm form = config_.kept_surfaces->form_for(pixel_count(), light_.light_count(), has_lobes_);
    return (indirect_.is_wanted() || follows_mirrors_) && form == SurfaceForm::Points ? SurfaceForm::Samples : form;
}

void FrameSurfaces::begin_pass(std::uint32_t sample_index, bool collects_parts, bool may_keep) {
    choose_what_is_kept(sample_index, collects_parts, may_keep);
    light_.prepare_edits(is_asked_, camera_, config_.shafts, statistics_, progress_);
}

void FrameSurfaces::choose_what_is_kept(std::uint32_t sample_index, bool collects_parts, bool may_keep) {
    sample_index_ = sample_index;
    collects_parts_ = collects_parts;
    band_ = 0;
    ++pass_count_;
    const std::size_t light_count = light_.light_count();
    is_asked_.assign(light_count, 1);
    asked_light_count_ += light_count;
    pass_.reset();
    moved_.reset();
    is_new_ = true;
    const SurfaceForm form = config_.kept_surfaces && may_keep && !config_.data.is_wanted() &&
                                     config_.light_groups.empty() && !config_.passes.tells_paths() &&
                                     !scene_.has_shadow_catchers() && !sent_air_
                                 ? form_for_pass()
                                 : SurfaceForm::Nothing;
    if (form == SurfaceForm::Nothing)
        return;
    SurfaceKey key = this->key(sample_index, collects_parts);
    if (const auto kept = config_.kept_surfaces->find(key); kept && kept->form == form) {
        const std::vector<KeptLight> now = lights_now();
        kept->lights.resize(light_count);
        moved_ = moved_since(*kept);
        for (std::size_t light = 0; light < light_count; ++light)
            is_asked_[light] = kept->lights[light] == now[light] && !(moved_ && !light_.is_told_by_rays(light)) ? 0 : 1;
        const auto changed = static_cast<std::size_t>(std::ranges::count(is_asked_, 1));
        if (form == SurfaceForm::Points || (changed == 0 && kept->light_count == light_count && !moved_)) {
            kept->is_at_work = true;
            // Until all of its bands are done, their light is of neither state.
            for (std::size_t light = 0; light < light_count; ++light)
                if (is_asked_[light] != 0)
                    kept->lights[light] = {};
            kept->light_count = light_count;
            pass_ = kept;
            is_new_ = false;
            ++kept_pass_count_;
            asked_light_count_ -= light_count - changed;
            kept_light_count_ += light_count - changed;
            return;
        }
        std::ranges::fill(is_asked_, 1);
        moved_.reset();
    }
    pass_ = std::make_shared<KeptPass>();
    pass_->key = std::move(key);
    pass_->form = form;
    pass_->light_count = light_count;
}

void FrameSurfaces::trace(std::uint32_t first_row, std::uint32_t end_row, std::span<const std::uint8_t> is_active,
                          const SurfacePass::Deliver& deliver, WaitingParts& waiting, const Progress& progress) {
    const ViewPath path = view_path(collects_parts_);
    const SurfacePass pass(path, camera_, region_, filter_, pass_config());
    SurfacePass::Kept kept{.form = SurfaceForm::Nothing, .parts = {}, .is_asked = is_asked_};
    kept.moved = moved_ ? &*moved_ : nullptr;
    kept.indirect = indirect_.is_wanted() ? &indirect_ : nullptr;
    kept.data = config_.data.is_wanted() ? &config_.data : nullptr;
    kept.group_count = config_.light_groups.size();
    std::vector<SurfaceBlock> of_this_pass;
    std::vector<SurfaceBlock>* blocks = &of_this_pass;
    if (pass_) {
        kept.form = pass_->form;
        kept.parts = pass_->key.parts;
        if (band_ == pass_->bands.size())
            pass_->bands.emplace_back();
        blocks = &pass_->bands[band_++];
    }
    pass.trace({.sample_index = sample_index_, .first_row = first_row, .end_row = end_row}, is_active, kept, *blocks,
               deliver, waiting, progress);
}

void FrameSurfaces::end_pass() {
    if (!pass_)
        return;
    pass_->finish(lights_now());
    count_blocks();
    if (is_new_)
        config_.kept_surfaces->keep(pass_);
    else
        config_.kept_surfaces->count_again(*pass_);
    pass_.reset();
}

void FrameSurfaces::count_blocks() {
    if (!moved_)
        return;
    for (const std::vector<SurfaceBlock>& band : pass_->bands)
        for (const SurfaceBlock& block : band) {
            ++(block.was_kept ? kept_block_count_ : walked_block_count_);
            const std::size_t point_lights = block.walk.points.size() * light_.light_count();
            const std::size_t again = block.was_kept ? block.lit_again_count : point_lights;
            lit_again_count_ += again;
            kept_lit_count_ += point_lights - again;
        }
}

void FrameSurfaces::count(Statistics& statistics) const {
    if (!config_.kept_surfaces)
        return;
    statistics.count("surfaces: passes kept", static_cast<double>(kept_pass_count_));
    statistics.count("surfaces: passes walked", static_cast<double>(pass_count_ - kept_pass_count_));
    statistics.count("surfaces: lights kept", static_cast<double>(kept_light_count_));
    statistics.count("surfaces: lights asked", static_cast<double>(asked_light_count_));
    if (kept_block_count_ + walked_block_count_ > 0) {
        statistics.count("moved objects: blocks of pixels kept", static_cast<double>(kept_block_count_));
        statistics.count("moved objects: blocks of pixels walked", static_cast<double>(walked_block_count_));
        statistics.count("moved objects: light on points kept", static_cast<double>(kept_lit_count_));
        statistics.count("moved objects: light on points asked", static_cast<double>(lit_again_count_));
    }
    statistics.count("kept surfaces: bytes", static_cast<double>(config_.kept_surfaces->bytes()));
}
} // namespace tyndall::render
