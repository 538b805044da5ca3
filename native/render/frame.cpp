// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/frame.hpp"
#include "core/errors.hpp"
#include "core/parallel.hpp"
#include "render/frame_shafts.hpp"
#include "render/frame_style.hpp"
#include "render/frame_surfaces.hpp"
#include "render/light_groups.hpp"
#include "render/pixel_centres.hpp"
#include "render/pixel_noise.hpp"
#include "render/surface_pass.hpp"
#include "render/tile.hpp"
#include "scene/instance_places.hpp"
#include <algorithm>
#include <chrono>
#include <iterator>
#include <optional>

namespace tyndall::render {
namespace {
using Clock = std::chrono::steady_clock;
/// A band of the picture is complete after at most this many pixels: the picture grows while it renders.
constexpr std::uint32_t pixels_per_band = 1 << 16;
/// The first band is small: something shows at once.
constexpr std::uint32_t pixels_of_first_band = 1 << 12;
constexpr std::chrono::milliseconds least_update_interval{500};
/// What one sample's camera rays and their light shafts take of its time, roughly, for the progress bar.
constexpr double surface_share = 0.3;

void require_in_reach(const Camera& camera, const Scene& scene) {
    require(
        is_within(camera.position(), scene.reach_m()), "the camera stands beyond ", scene.reach_m(),
        " m, from where rays do not meet the thinnest or smallest object: enlarge that, or bring the camera nearer");
}

CatcherFilm catcher_film(const Scene& scene, const FrameConfig& config) {
    if (!scene.has_shadow_catchers())
        return CatcherFilm::None;
    return config.is_film_transparent ? CatcherFilm::Transparent : CatcherFilm::World;
}

/// The samples that the strata of lights are dealt out to. Air that is seen through a place on the lens has strata of its
/// own (Lens::air_u), and so has a part of a series: frames beside it see others, and what this one leaves out nobody asks.
std::uint32_t strata_round(const Camera& camera, const FrameConfig& config) {
    return camera.lens.air_u || !config.shafts.part.is_whole() ? config.taken_samples() : config.pixel_samples;
}

class FrameRenderer {
public:
    FrameRenderer(const Scene& scene, const Media& media, const Camera& camera, const FrameConfig& config,
                  Progress& progress, const OnUpdate& on_update)
        : scene_(scene), camera_(camera), air_camera_(camera.of_air()), config_(config), progress_(progress),
          on_update_(on_update), region_(checked_region(config, camera)), media_(media),
          surfaces_(scene, media, camera, region_, config, statistics_, progress),
          sums_(region_.x1 - region_.x0, region_.y1 - region_.y0, config.passes, scene.description().origin_in_world,
                catcher_film(scene, config)),
          is_active_(pixel_count(), 1), active_count_(pixel_count()), round_samples_(strata_round(camera, config)) {
        if (config.noise_threshold > 0.0f && samples_per_round(config.taken_samples()) < config.taken_samples()) {
            round_samples_ = samples_per_round(config.taken_samples());
            noise_.emplace(width(), region_.y1 - region_.y0, surfaces_.turn_samples());
        }
        if (config.data.is_wanted())
            data_.emplace(pixel_count(), config.taken_samples(), scene, config.data);
        if (!config.light_groups.empty())
            groups_.emplace(pixel_count(), config.light_groups, config.passes.has(Pass::Shafts));
        if (media_.is_empty())
            statistics_.skip("light shafts", "no medium in the scene");
        else if (!config.transfer_functions.empty())
            style_.emplace(scene, air_camera_, config, width(), region_.y1 - region_.y0);
        set_heterogeneity();
    }

    Film render() {
        const std::vector<Band> bands = all_bands();
        see_pixel_centres(surfaces_.view_path(), camera_, region_, config_, sums_, data_ ? &*data_ : nullptr,
                          progress_);
        for (std::uint32_t sample = config_.first_sample; sample < end_sample(); ++sample) {
            has_asked_all_ = surfaces_.turn_samples() == 1;
            render_sample(sample, bands);
            if (!has_asked_all_ && (sample - config_.first_sample + 1) % surfaces_.turn_samples() == 0) {
                has_asked_all_ = true;
                update_now_and_then();
            }
            sample_count_ += active_count_;
            if (noise_ && !has_noise_after(sample))
                break;
        }
        progress_.advance_to(1.0f);
        Film film = picture();
        statistics_.stages.push_back({"camera rays and direct light", surface_seconds_});
        if (shafts_) {
            statistics_.stages.push_back({"light shafts: scatter", shaft_seconds_});
            statistics_.count("light shafts: rays", static_cast<double>(shaft_ray_count_));
        }
        if (air_ && shafts_)
            air_->report(statistics_);
        if (style_)
            statistics_.stages.push_back({"transfer functions", style_seconds_});
        surfaces_.count(statistics_);
        statistics_.count("pixels", static_cast<double>(pixel_count()));
        statistics_.count("samples per pixel", static_cast<double>(sample_count_) / static_cast<double>(pixel_count()));
        film.statistics = std::move(statistics_);
        return film;
    }

private:
    /// So far.
    Film picture() {
        Film film = sums_.resolve(progress_);
        if (data_)
            film.data_planes = data_->resolve(progress_);
        if (groups_)
            std::ranges::move(groups_->resolve(progress_), std::back_inserter(film.data_planes));
        if (!style_)
            return film;
        const auto start = Clock::now();
        film = style_->apply(std::move(film), progress_);
        style_seconds_ = std::chrono::duration<double>(Clock::now() - start).count();
        return film;
    }
    [[nodiscard]] std::uint32_t end_sample() const { return config_.first_sample + config_.taken_samples(); }
    [[nodiscard]] bool is_first(std::uint32_t sample) const { return sample == config_.first_sample; }
    [[nodiscard]] std::uint32_t width() const { return region_.x1 - region_.x0; }
    [[nodiscard]] std::size_t pixel_count() const { return std::size_t{region_.y1 - region_.y0} * width(); }
    [[nodiscard]] std::vector<Band> all_bands() const {
        std::vector<Band> bands;
        for (std::uint32_t y = region_.y0, end_y = 0; y < region_.y1; y = end_y) {
            constexpr std::uint32_t step = SurfacePass::square_px;
            const std::uint32_t rows = std::max(1u, (bands.empty() ? pixels_of_first_band : pixels_per_band) / width());
            end_y = std::min((y + rows + step - 1) / step * step, region_.y1);
            bands.push_back({y - region_.y0, end_y - region_.y0});
        }
        return bands;
    }

    /// Whether the air has a texture that shows.
    void set_heterogeneity() {
        if (!config_.heterogeneity)
            return;
        require_usable(*config_.heterogeneity);
        if (media_.is_empty() || is_neutral(*config_.heterogeneity)) {
            statistics_.skip("heterogeneity", media_.is_empty() ? "no medium in the scene" : "it is 1 everywhere");
            return;
        }
        const StageTimer timer(statistics_, "heterogeneity: noise");
        air_.emplace(*config_.heterogeneity, camera_, region_, style_.has_value(), progress_);
    }

    [[nodiscard]] bool collects_parts(std::uint32_t sample) const {
        return is_first(sample) ? !media_.is_empty() : shafts_.has_value();
    }
    /// After a round of samples: whether some pixels go on.
    bool has_noise_after(std::uint32_t sample) {
        constexpr std::uint32_t least_turns = 4; // to tell noise from
        const std::uint32_t taken = sample - config_.first_sample + 1;
        noise_->end_sample(is_active_);
        if (taken % round_samples_ == 0 && taken >= least_turns * surfaces_.turn_samples() && sample + 1 < end_sample())
            active_count_ = noise_->keep_noisy(config_.noise_threshold, is_active_, progress_);
        return active_count_ > 0;
    }

    /// One pass: the surfaces of the whole picture, which then appears, and after them the shafts.
    void render_sample(std::uint32_t sample, const std::vector<Band>& bands) {
        waiting_.clear();
        world_lit_.assign(surfaces_.world_reach_px() > 0 ? pixel_count() : 0, WorldLit{});
        surfaces_.begin_pass(sample, collects_parts(sample), active_count_ == pixel_count());
        // A band's pixels look at neighbours in the next one.
        for (std::size_t index = 0; index <= bands.size(); ++index) {
            if (index < bands.size())
                trace(sample, bands[index]);
            if (surfaces_.world_reach_px() > 0 && index > 0)
                share_world_light(bands[index - 1]);
            update_now_and_then();
        }
        surfaces_.end_pass();
        if (air_ && (shafts_ || is_first(sample)))
            air_->begin_pass(surfaces_.view_path(), surfaces_.filter(), surfaces_.pass_config(), sample, waiting_,
                             progress_);
        if (is_first(sample) && !media_.is_empty())
            prepare_shafts();
        if (!shafts_)
            return;
        shafts_->begin_pass(pass_of_shafts(sample), progress_);
        // A band's pixels look at neighbours in the next one.
        for (std::size_t index = 0; index <= bands.size(); ++index) {
            if (index < bands.size())
                scatter(sample, bands[index]);
            if (index > 0) {
                add_shafts(bands[index - 1]);
                update_now_and_then();
            }
        }
    }

    /// Strata are dealt out to the passes of a round: where pixels may stop, rounds begin with this frame's first sample.
    [[nodiscard]] std::uint32_t pass_of_shafts(std::uint32_t sample) const {
        return noise_ ? sample - config_.first_sample % round_samples_ : sample;
    }
    /// The parts of all rays of the first sample, which a render of the full frame prepares its lights for.
    [[nodiscard]] WaitingParts parts_of_frame() const {
        WaitingParts parts;
        if (!config_.is_tile)
            return parts;
        const ViewPath path = surfaces_.view_path();
        const Region frame{0, 0, camera_.width_px, camera_.height_px};
        SurfacePass(path, camera_, frame, surfaces_.filter(), surfaces_.pass_config())
            .find_parts({.sample_index = config_.first_sample, .first_row = 0, .end_row = camera_.height_px}, parts,
                        progress_);
        return parts;
    }

    void prepare_shafts() {
        const StageTimer timer(statistics_, "light shafts: prepare");
        const WaitingParts of_frame = parts_of_frame();
        FrameShafts::Config config{.shafts = config_.shafts,
                                   .round_samples = round_samples_,
                                   .wants_visibility = sums_.wants(Pass::ShaftsVisibility) ||
                                                       asks_for(transfer_functions::Axis::AverageVisibility),
                                   .wants_lit_moments = asks_for(transfer_functions::Axis::MeanLitPosition),
                                   .of_frame = config_.is_tile ? &of_frame : nullptr,
                                   .air = air_ ? &*air_ : nullptr,
                                   .pixel_samples = config_.pixel_samples,
                                   .seed = config_.seed,
                                   .taken_samples = config_.taken_samples(),
                                   .emitters = &surfaces_.emitters(),
                                   .pilot = &surfaces_.pilot(),
                                   .kept_light_trees = config_.kept_light_trees.get(),
                                   .may_draw = !style_};
        config.shafts.keeps_groups_apart = groups_.has_value();
        if (style_)
            config.shafts.visibility_light = style_->parameters().visibility_light();
        shafts_.emplace(scene_, media_, air_camera_, region_, waiting_, config, statistics_, progress_);
        if (style_ && shafts_->has_glow())
            report_glow_in_style();
        if (shafts_->is_empty())
            shafts_.reset();
        else if (style_)
            style_->see_shafts(surfaces_.view_path(), shafts_->prepared(), progress_);
    }
    void report_glow_in_style() {
        using transfer_functions::Axis;
        if (!asks_for(Axis::AverageVisibility) && !asks_for(Axis::MeanLitPosition))
            return;
        const std::uint32_t instance = surfaces_.emitters().instances().front();
        const SceneDescription& description = scene_.description();
        statistics_.report("Object \"" + description.object_names[description.name_index_of(instance)] +
                           "\" glows in fog: transfer functions know of the visibility of lamps and the world alone");
    }
    [[nodiscard]] vec2 pixel_centre(std::size_t pixel) const {
        return {static_cast<float>(region_.x0 + pixel % width()) + 0.5f,
                static_cast<float>(region_.y0 + pixel / width()) + 0.5f};
    }

    void advance(std::uint32_t sample, const Band& band, double share_before, double share_of_sample) {
        const double done = static_cast<double>(band.end_row) / static_cast<double>(region_.y1 - region_.y0);
        const double samples = sample - config_.first_sample + share_before + done * share_of_sample;
        progress_.advance_to(static_cast<float>(samples / config_.taken_samples()));
    }
    void say(std::uint32_t sample, const char* stage) {
        progress_.set_message("Sample " + std::to_string(sample + 1) + " of " + std::to_string(config_.pixel_samples) +
                              ": " + stage);
    }

    /// Adds the surfaces' light of one sample to each pixel; appends the parts of its rays that lie in media.
    void trace(std::uint32_t sample, const Band& band) {
        say(sample, "surfaces");
        const auto start = Clock::now();
        surfaces_.trace(
            band.first_row, band.end_row, is_active_,
            [&](std::size_t pixel, const PathSample& found, const PathData* data) {
                sums_.add(pixel, found);
                if (groups_)
                    groups_->add(pixel, found);
                if (data != nullptr)
                    data_->add(pixel, *data);
                if (style_)
                    style_->see(pixel, found);
                if (noise_)
                    noise_->add(pixel, found.radiance + found.shadow());
                if (surfaces_.world_reach_px() > 0)
                    world_lit_[pixel] = found.world_lit;
            },
            waiting_, progress_);
        surface_seconds_ += std::chrono::duration<double>(Clock::now() - start).count();
        advance(sample, band, 0.0, collects_parts(sample) ? surface_share : 1.0);
    }

    void share_world_light(const Band& band) {
        const auto start = Clock::now();
        parallel_for(
            band.end_row - band.first_row, progress_,
            [&](std::size_t row) {
                const auto y = static_cast<std::uint32_t>(band.first_row + row);
                for (std::uint32_t x = 0; x < width(); ++x) {
                    const std::size_t pixel = std::size_t{y} * width() + x;
                    const Rgb gain = shared_light_gain(world_lit_, width(), surfaces_.world_reach_px(), x, y);
                    if (gain == Rgb(0.0f))
                        continue;
                    sums_.add_world_light(pixel, gain);
                    if (groups_)
                        groups_->add_light(pixel, scene_.world().light_group(), gain);
                    if (noise_)
                        noise_->add(pixel, gain);
                }
            },
            1);
        surface_seconds_ += std::chrono::duration<double>(Clock::now() - start).count();
    }

    /// Asks for the light that the media scatter into the parts of a band.
    void scatter(std::uint32_t sample, const Band& band) {
        say(sample, "light shafts");
        const auto start = Clock::now();
        shaft_ray_count_ += shafts_->scatter(band, progress_);
        shaft_seconds_ += std::chrono::duration<double>(Clock::now() - start).count();
        advance(sample, band, surface_share, 1.0 - surface_share);
    }

    /// Adds that light to the film, with what the neighbours of each pixel have found.
    void add_shafts(const Band& band) {
        const auto start = Clock::now();
        const auto add = [&](std::size_t pixel, const SeenShafts& seen, std::span<const Rgb> by_slot) {
            if (seen.meets_medium)
                sums_.add_shafts(pixel, seen.textured_radiance, seen.visibility);
            for (std::size_t slot = 0; groups_ && slot < by_slot.size(); ++slot)
                groups_->add_shafts(pixel, shafts_->slots()[slot], by_slot[slot]);
            if (style_ && is_active_[pixel])
                style_->add(pixel, pixel_centre(pixel), seen);
            if (noise_)
                noise_->add(pixel, seen.textured_radiance);
        };
        shafts_->sum(band, add, progress_);
        shaft_seconds_ += std::chrono::duration<double>(Clock::now() - start).count();
    }

    [[nodiscard]] bool asks_for(transfer_functions::Axis axis) const {
        return style_ && style_->parameters().asks_for(axis);
    }

    void update_now_and_then() {
        const bool is_complete = progress_.fraction() >= 1.0f; // the caller gets that film anyway
        if (!on_update_ || is_complete || !has_asked_all_ ||
            (last_update_ && Clock::now() - *last_update_ < update_interval_))
            return;
        const auto start = Clock::now();
        on_update_(picture());
        last_update_ = Clock::now();
        // A large film takes a while to hand out: never more than a tenth of the time.
        update_interval_ = std::max<Clock::duration>(least_update_interval, 9 * (*last_update_ - start));
    }

    const Scene& scene_;
    const Camera& camera_;
    const Camera air_camera_; ///< Whose rays the parts in media are.
    const FrameConfig& config_;
    Progress& progress_;
    const OnUpdate& on_update_;
    Statistics statistics_; // before surfaces_, which report into it
    Region region_;
    const Media& media_;
    FrameSurfaces surfaces_;
    FilmSums sums_;
    std::optional<DataSums> data_;        ///< Of data passes; nothing: none is asked for.
    std::optional<GroupSums> groups_;     ///< Of light groups; nothing: none is asked for.
    bool has_asked_all_ = true;           ///< Each light has had its turn: the picture so far can be shown.
    std::optional<PixelNoise> noise_;     ///< None: every pixel takes all samples.
    std::vector<std::uint8_t> is_active_; ///< Per pixel: takes further samples.
    std::size_t active_count_, sample_count_ = 0;
    std::uint32_t round_samples_;
    std::vector<WorldLit> world_lit_;   ///< Per pixel, of one pass, where neighbours share it.
    WaitingParts waiting_;              ///< Of the current pass; kept for its memory.
    std::optional<FrameAir> air_;       ///< Where the air has a texture.
    std::optional<FrameShafts> shafts_; ///< None before the first sample's rays are known, or where none scatter.
    std::optional<FrameStyle> style_;   ///< Where functions recolour the light shafts.
    std::size_t shaft_ray_count_ = 0;
    double surface_seconds_ = 0.0, shaft_seconds_ = 0.0, style_seconds_ = 0.0;
    std::optional<Clock::time_point> last_update_;
    Clock::duration update_interval_ = least_update_interval;
};
} // namespace

Film render(const Scene& scene, const Media& media, const Camera& camera, const FrameConfig& config, Progress& progress,
            const OnUpdate& on_update) {
    require_usable(camera);
    require_in_reach(camera, scene);
    return with_threads(config.thread_count, [&] {
        if (!config.is_tile)
            return FrameRenderer(scene, media, camera, config, progress, on_update).render();
        const Region tile = checked_region(config, camera);
        const FrameConfig grown = grown_tile(config, tile, camera);
        return cropped(FrameRenderer(scene, media, camera, grown, progress, {}).render(), *grown.region, tile);
    });
}

Film render(const Scene& scene, const Camera& camera, const FrameConfig& config, Progress& progress,
            const OnUpdate& on_update) {
    const Media media(scene, progress);
    return render(scene, media, camera, config, progress, on_update);
}
} // namespace tyndall::render
