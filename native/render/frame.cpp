// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/frame.hpp"
#include "core/parallel.hpp"
#include "render/view_path.hpp"
#include <algorithm>
#include <chrono>
#include <optional>

namespace tyndall::render {
namespace {
using Clock = std::chrono::steady_clock;
constexpr std::size_t pixels_per_block = 128;
/// A band of the picture is complete after at most this many pixels: the picture grows while it renders.
constexpr std::uint32_t pixels_per_band = 1 << 16;
constexpr std::chrono::milliseconds least_update_interval{500};
/// What one sample's camera rays and their light shafts take of its time, roughly, for the progress bar.
constexpr double surface_share = 0.3;

/// Parts of view rays that wait for their scattered light, in the order of their pixels.
struct WaitingParts {
    std::vector<std::size_t> pixels;
    std::vector<light_shafts::ViewRay> rays;
    std::vector<Rgb> weights;

    void append(const WaitingParts& other) {
        pixels.insert(pixels.end(), other.pixels.begin(), other.pixels.end());
        rays.insert(rays.end(), other.rays.begin(), other.rays.end());
        weights.insert(weights.end(), other.weights.begin(), other.weights.end());
    }
};
struct Band {
    std::size_t first_pixel, pixel_count;
};

Region checked_region(const Camera& camera, const FrameConfig& config) {
    require(camera.width_px > 0 && camera.height_px > 0, "the camera's frame has no pixels");
    const Region region = config.region.value_or(Region{0, 0, camera.width_px, camera.height_px});
    require(region.x0 < region.x1 && region.y0 < region.y1 && region.x1 <= camera.width_px &&
                region.y1 <= camera.height_px,
            "region [", region.x0, ", ", region.x1, ") x [", region.y0, ", ", region.y1,
            ") does not lie in the frame of ", camera.width_px, " x ", camera.height_px, " pixels");
    return region;
}

class FrameRenderer {
public:
    FrameRenderer(const Scene& scene, const Media& media, const Camera& camera, const FrameConfig& config,
                  Progress& progress, const OnUpdate& on_update)
        : scene_(scene), camera_(camera), config_(config), progress_(progress), on_update_(on_update),
          region_(checked_region(camera, config)), filter_(config.pixel_filter, config.filter_width_px), media_(media),
          light_(scene, media_, statistics_),
          sums_(region_.x1 - region_.x0, region_.y1 - region_.y0, config.passes, scene.description().origin_in_world) {
        require(1 <= config.pixel_samples && config.pixel_samples <= 65536, "pixel_samples is ", config.pixel_samples,
                ", outside [1, 65536]");
        if (media_.is_empty())
            statistics_.skip("light shafts", "no medium in the scene");
    }

    Film render() {
        const std::vector<Band> bands = all_bands();
        render_first_sample(bands);
        for (std::uint32_t sample = 1; sample < config_.pixel_samples; ++sample)
            for (const Band& band : bands) {
                scatter(sample, band, trace(sample, band));
                update_now_and_then();
            }
        Film film = sums_.resolve(progress_);
        statistics_.stages.push_back({"camera rays and direct light", surface_seconds_});
        if (shafts_) {
            statistics_.stages.push_back({"light shafts: scatter", shaft_seconds_});
            statistics_.count("light shafts: rays", static_cast<double>(shaft_ray_count_));
        }
        statistics_.count("pixels", static_cast<double>(pixel_count()));
        statistics_.count("samples per pixel", config_.pixel_samples);
        film.statistics = std::move(statistics_);
        return film;
    }

private:
    [[nodiscard]] std::uint32_t width() const { return region_.x1 - region_.x0; }
    [[nodiscard]] std::size_t pixel_count() const { return std::size_t{region_.y1 - region_.y0} * width(); }
    [[nodiscard]] std::vector<Band> all_bands() const {
        const std::size_t size = std::size_t{std::max(1u, pixels_per_band / width())} * width();
        std::vector<Band> bands;
        for (std::size_t first = 0; first < pixel_count(); first += size)
            bands.push_back({first, std::min(size, pixel_count() - first)});
        return bands;
    }

    /// Surfaces of the whole frame before any shafts: the picture appears, and the shafts are prepared for all its rays.
    void render_first_sample(const std::vector<Band>& bands) {
        std::vector<WaitingParts> waiting;
        for (const Band& band : bands) {
            waiting.push_back(trace(0, band));
            update_now_and_then();
        }
        if (!media_.is_empty())
            prepare_shafts(waiting);
        for (std::size_t index = 0; index < bands.size(); ++index) {
            scatter(0, bands[index], waiting[index]);
            waiting[index] = {};
            update_now_and_then();
        }
    }

    void prepare_shafts(const std::vector<WaitingParts>& waiting) {
        std::vector<light_shafts::ViewRay> rays;
        for (const WaitingParts& parts : waiting)
            rays.insert(rays.end(), parts.rays.begin(), parts.rays.end());
        const StageTimer timer(statistics_, "light shafts: prepare");
        const light_shafts::View view{.is_orthographic = camera_.kind == CameraKind::Orthographic,
                                      .position = camera_.position(),
                                      .direction = camera_.forward()};
        shafts_.emplace(scene_, media_, view, rays, config_.shafts, progress_);
        statistics_.append(shafts_->statistics());
        if (shafts_->is_empty())
            shafts_.reset();
    }

    void advance(std::uint32_t sample, const Band& band, double share_of_sample) {
        const double done =
            static_cast<double>(band.first_pixel + band.pixel_count) / static_cast<double>(pixel_count());
        const double before = share_of_sample == 1.0 && sample == 0 && shafts_ ? surface_share : 0.0;
        progress_.advance_to(
            static_cast<float>((sample + before + done * (share_of_sample - before)) / config_.pixel_samples));
    }
    void say(std::uint32_t sample, const char* stage) {
        progress_.set_message("Sample " + std::to_string(sample + 1) + " of " + std::to_string(config_.pixel_samples) +
                              ": " + stage);
    }

    /// Adds the surfaces' light of one sample to each pixel; returns the parts of its rays that lie in media.
    WaitingParts trace(std::uint32_t sample, const Band& band) {
        say(sample, "surfaces");
        const auto start = Clock::now();
        const bool has_shafts = sample == 0 ? !media_.is_empty() : shafts_.has_value();
        const ViewPath path(scene_, media_, light_, camera_,
                            {.is_film_transparent = config_.is_film_transparent,
                             .collects_parts = has_shafts,
                             .lights_black_surfaces = config_.passes.has(Pass::Shadow)});
        std::vector<WaitingParts> blocks((band.pixel_count + pixels_per_block - 1) / pixels_per_block);
        parallel_blocks(band.pixel_count, pixels_per_block, progress_, [&](std::size_t begin, std::size_t end) {
            std::vector<MediumPart> parts;
            WaitingParts& block = blocks[begin / pixels_per_block];
            for (std::size_t index = begin; index < end; ++index) {
                progress_.poll();
                const std::size_t pixel = band.first_pixel + index;
                parts.clear();
                const Ray ray = trace_pixel(path, pixel, sample, parts);
                for (const MediumPart& part : parts) {
                    block.pixels.push_back(pixel);
                    block.rays.push_back({ray.origin, ray.direction, part.near_m, part.far_m});
                    block.weights.push_back(part.weight);
                }
            }
        });
        WaitingParts waiting;
        for (const WaitingParts& block : blocks)
            waiting.append(block);
        surface_seconds_ += std::chrono::duration<double>(Clock::now() - start).count();
        advance(sample, band, has_shafts ? surface_share : 1.0);
        return waiting;
    }

    Ray trace_pixel(const ViewPath& path, std::size_t pixel, std::uint32_t sample, std::vector<MediumPart>& parts) {
        const auto x = region_.x0 + static_cast<std::uint32_t>(pixel % width());
        const auto y = region_.y0 + static_cast<std::uint32_t>(pixel / width());
        // By the place in the full frame: a region has the full frame's noise, too.
        PixelSamples samples(hash(config_.seed, y * camera_.width_px + x), sample);
        const vec2 offset = config_.pixel_samples == 1 ? vec2(0.0f) : filter_.offset_px(samples.next_pair());
        const Ray ray = camera_.ray(static_cast<float>(x) + 0.5f + offset.x, static_cast<float>(y) + 0.5f + offset.y);
        sums_.add(pixel, path.follow(ray, samples, parts));
        return ray;
    }

    /// Adds the light that the media scatter into the parts of a band's rays.
    void scatter(std::uint32_t sample, const Band& band, const WaitingParts& parts) {
        if (!shafts_)
            return;
        say(sample, "light shafts");
        const auto start = Clock::now();
        std::vector<Rgb> radiance(parts.rays.size());
        std::vector<float> visibility(sums_.wants(Pass::ShaftsVisibility) ? parts.rays.size() : 0);
        shafts_->scatter(parts.rays, radiance, visibility, progress_, {sample, config_.pixel_samples});
        for (std::size_t first = 0; first < parts.rays.size();) {
            Rgb sum(0.0f);
            float visible = 0.0f, weight_sum = 0.0f;
            std::size_t part = first;
            for (; part < parts.rays.size() && parts.pixels[part] == parts.pixels[first]; ++part) {
                const Rgb& weight = parts.weights[part];
                sum += weight * radiance[part];
                const float total = weight.x + weight.y + weight.z;
                weight_sum += total;
                visible += visibility.empty() ? 0.0f : total * visibility[part];
            }
            sums_.add_shafts(parts.pixels[first], sum, weight_sum > 0.0f ? visible / weight_sum : 0.0f);
            first = part;
        }
        shaft_ray_count_ += parts.rays.size();
        shaft_seconds_ += std::chrono::duration<double>(Clock::now() - start).count();
        advance(sample, band, 1.0);
    }

    void update_now_and_then() {
        const bool is_complete = progress_.fraction() >= 1.0f; // the caller gets that film anyway
        if (!on_update_ || is_complete || (last_update_ && Clock::now() - *last_update_ < update_interval_))
            return;
        const auto start = Clock::now();
        on_update_(sums_.resolve(progress_));
        last_update_ = Clock::now();
        // A large film takes a while to hand out: never more than a tenth of the time.
        update_interval_ = std::max<Clock::duration>(least_update_interval, 9 * (*last_update_ - start));
    }

    const Scene& scene_;
    const Camera& camera_;
    const FrameConfig& config_;
    Progress& progress_;
    const OnUpdate& on_update_;
    Statistics statistics_; // before light_, which reports into it
    Region region_;
    FilterSampler filter_;
    const Media& media_;
    DirectLight light_;
    FilmSums sums_;
    std::optional<light_shafts::Shafts>
        shafts_; ///< None before the first sample's rays are known, or where none scatter.
    std::size_t shaft_ray_count_ = 0;
    double surface_seconds_ = 0.0, shaft_seconds_ = 0.0;
    std::optional<Clock::time_point> last_update_;
    Clock::duration update_interval_ = least_update_interval;
};
} // namespace

Film render(const Scene& scene, const Media& media, const Camera& camera, const FrameConfig& config, Progress& progress,
            const OnUpdate& on_update) {
    require_usable(camera);
    return with_threads(config.thread_count,
                        [&] { return FrameRenderer(scene, media, camera, config, progress, on_update).render(); });
}

Film render(const Scene& scene, const Camera& camera, const FrameConfig& config, Progress& progress,
            const OnUpdate& on_update) {
    const Media media(scene, progress);
    return render(scene, media, camera, config, progress, on_update);
}
} // namespace tyndall::render
