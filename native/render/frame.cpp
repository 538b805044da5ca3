// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/frame.hpp"
#include "core/parallel.hpp"
#include "render/statistics_sum.hpp"
#include "render/view_path.hpp"
#include <algorithm>
#include <chrono>

namespace tyndall::render {
namespace {
using Clock = std::chrono::steady_clock;
constexpr std::size_t pixels_per_block = 128;
/// The exact strip takes seconds: in bands of this many pixels the picture grows while it works. The other methods
/// prepare once per call, so that one call takes the whole frame.
constexpr std::uint32_t pixels_per_exact_band = 1 << 16;
constexpr std::chrono::milliseconds update_interval{500};

/// A part of a view ray that waits for its scattered light.
struct WaitingPart {
    std::size_t pixel;
    light_shafts::ViewRay ray;
    Rgb weight;
};
using Block = std::vector<WaitingPart>;

Region checked_region(const Camera& camera, const FrameConfig& config) {
    require(camera.width_px > 0 && camera.height_px > 0, "the camera's frame has no pixels");
    const Region region = config.region.value_or(Region{0, 0, camera.width_px, camera.height_px});
    require(region.x0 < region.x1 && region.y0 < region.y1 && region.x1 <= camera.width_px &&
                region.y1 <= camera.height_px,
            "region [", region.x0, ", ", region.x1, ") x [", region.y0, ", ", region.y1,
            ") does not lie in the frame of ", camera.width_px, " x ", camera.height_px, " pixels");
    return region;
}

/// Why nothing scatters; empty if something does.
std::string no_shafts_because(const Scene& scene, const Media& media, const light_shafts::Config& config) {
    if (media.is_empty())
        return "no medium in the scene";
    const std::vector<Medium>& all_media = scene.description().media;
    if (std::all_of(all_media.begin(), all_media.end(), [](const Medium& m) { return m.sigma_s_per_m() == Rgb(0.0f); }))
        return "no medium scatters";
    const bool has_light = std::any_of(scene.lights().begin(), scene.lights().end(), [](const Light& light) {
        return light.scatters_in_media && light.strength != Rgb(0.0f);
    });
    if (!has_light && (scene.world().is_black() || config.world_samples == 0))
        return "no light scatters in media";
    return {};
}

class FrameRenderer {
public:
    FrameRenderer(const Scene& scene, const Camera& camera, const FrameConfig& config, Progress& progress,
                  const OnUpdate& on_update)
        : scene_(scene), camera_(camera), config_(config), progress_(progress), on_update_(on_update),
          region_(checked_region(camera, config)), filter_(config.pixel_filter, config.filter_width_px),
          media_(scene, progress), light_(scene, media_, statistics_),
          sums_(region_.x1 - region_.x0, region_.y1 - region_.y0, config.passes, scene.description().origin_in_world) {
        require(1 <= config.pixel_samples && config.pixel_samples <= 65536, "pixel_samples is ", config.pixel_samples,
                ", outside [1, 65536]");
        const std::string reason = no_shafts_because(scene, media_, config.shafts);
        has_shafts_ = reason.empty();
        if (!has_shafts_)
            statistics_.skip("light shafts", reason);
    }

    Film render() {
        const std::uint32_t band_height = rows_per_band();
        for (std::uint32_t sample = 0; sample < config_.pixel_samples; ++sample)
            for (std::uint32_t y = region_.y0; y < region_.y1; y += band_height)
                render_band(sample, y, std::min(region_.y1, y + band_height));
        Film film = sums_.resolve();
        statistics_.stages.push_back({"camera rays and direct light", surface_seconds_});
        if (has_shafts_)
            statistics_.stages.push_back({"light shafts", shaft_seconds_});
        statistics_.count("pixels", static_cast<double>(width()) * (region_.y1 - region_.y0));
        statistics_.count("samples per pixel", config_.pixel_samples);
        film.statistics = std::move(statistics_);
        return film;
    }

private:
    [[nodiscard]] std::uint32_t width() const { return region_.x1 - region_.x0; }
    [[nodiscard]] std::uint32_t rows_per_band() const {
        if (!has_shafts_ || config_.shafts.method != light_shafts::Method::Exact)
            return region_.y1 - region_.y0;
        return std::max(1u, pixels_per_exact_band / width());
    }

    void render_band(std::uint32_t sample, std::uint32_t y_begin, std::uint32_t y_end) {
        const std::size_t first_pixel = std::size_t{y_begin - region_.y0} * width();
        const std::size_t pixel_count = std::size_t{y_end - y_begin} * width();
        const std::size_t all_pixels = std::size_t{region_.y1 - region_.y0} * width();
        const double share = static_cast<double>(pixel_count) / static_cast<double>(all_pixels);
        const double done = sample + static_cast<double>(first_pixel) / static_cast<double>(all_pixels);
        const auto advance = [&](double part) {
            progress_.advance_to(static_cast<float>((done + part * share) / config_.pixel_samples));
        };
        progress_.set_message("Sample " + std::to_string(sample + 1) + " of " + std::to_string(config_.pixel_samples) +
                              ": surfaces");
        const auto start = Clock::now();
        std::vector<Block> blocks = trace(sample, first_pixel, pixel_count);
        const auto traced = Clock::now();
        surface_seconds_ += std::chrono::duration<double>(traced - start).count();
        if (has_shafts_) {
            advance(0.25);
            update_now_and_then();
            progress_.set_message("Sample " + std::to_string(sample + 1) + " of " +
                                  std::to_string(config_.pixel_samples) + ": light shafts");
            scatter(blocks);
            shaft_seconds_ += std::chrono::duration<double>(Clock::now() - traced).count();
        }
        advance(1.0);
        const bool is_last = sample + 1 == config_.pixel_samples && first_pixel + pixel_count == all_pixels;
        if (!is_last)
            update_now_and_then();
    }

    /// Adds the surfaces' light of one sample to each pixel; returns the parts of its rays that lie in media.
    std::vector<Block> trace(std::uint32_t sample, std::size_t first_pixel, std::size_t pixel_count) {
        const ViewPath path(scene_, media_, light_, camera_,
                            {.is_film_transparent = config_.is_film_transparent,
                             .collects_parts = has_shafts_,
                             .lights_black_surfaces = config_.passes.has(Pass::Shadow)});
        std::vector<Block> blocks((pixel_count + pixels_per_block - 1) / pixels_per_block);
        parallel_blocks(pixel_count, pixels_per_block, progress_, [&](std::size_t begin, std::size_t end) {
            std::vector<MediumPart> parts;
            for (std::size_t index = begin; index < end; ++index) {
                progress_.poll();
                const std::size_t pixel = first_pixel + index;
                const auto x = region_.x0 + static_cast<std::uint32_t>(pixel % width());
                const auto y = region_.y0 + static_cast<std::uint32_t>(pixel / width());
                // By the place in the full frame: a region shows the full frame's noise, too.
                PixelSamples samples(hash(config_.seed, y * camera_.width_px + x), sample);
                const vec2 offset = config_.pixel_samples == 1 ? vec2(0.0f) : filter_.offset_px(samples.next_pair());
                const Ray ray =
                    camera_.ray(static_cast<float>(x) + 0.5f + offset.x, static_cast<float>(y) + 0.5f + offset.y);
                parts.clear();
                sums_.add(pixel, path.follow(ray, samples, parts));
                for (const MediumPart& part : parts)
                    blocks[begin / pixels_per_block].push_back(
                        {pixel, {ray.origin, ray.direction, part.near_m, part.far_m}, part.weight});
            }
        });
        return blocks;
    }

    /// Adds the light that the media scatter into the parts.
    void scatter(const std::vector<Block>& blocks) {
        std::vector<light_shafts::ViewRay> rays;
        std::vector<std::size_t> first_ray;
        for (const Block& block : blocks) {
            first_ray.push_back(rays.size());
            for (const WaitingPart& part : block)
                rays.push_back(part.ray);
        }
        if (rays.empty())
            return;
        const light_shafts::View view{.is_orthographic = camera_.kind == CameraKind::Orthographic,
                                      .position = camera_.position(),
                                      .direction = camera_.forward()};
        const light_shafts::Result shafts = light_shafts::run(scene_, view, rays, config_.shafts, progress_);
        add_up(statistics_, shafts.statistics);
        parallel_for(
            blocks.size(), progress_,
            [&](std::size_t index) {
                const Block& block = blocks[index];
                for (std::size_t first = 0; first < block.size();) {
                    Rgb radiance(0.0f);
                    float visibility = 0.0f, weight = 0.0f;
                    std::size_t last = first;
                    for (; last < block.size() && block[last].pixel == block[first].pixel; ++last) {
                        const std::size_t ray = first_ray[index] + last;
                        const Rgb& share = block[last].weight;
                        radiance += share * shafts.radiance[ray];
                        visibility += (share.x + share.y + share.z) * shafts.average_visibility[ray];
                        weight += share.x + share.y + share.z;
                    }
                    sums_.add_shafts(block[first].pixel, radiance, weight > 0.0f ? visibility / weight : 0.0f);
                    first = last;
                }
            },
            16);
    }

    void update_now_and_then() {
        if (!on_update_ || (last_update_ && Clock::now() - *last_update_ < update_interval))
            return;
        on_update_(sums_.resolve());
        last_update_ = Clock::now();
    }

    const Scene& scene_;
    const Camera& camera_;
    const FrameConfig& config_;
    Progress& progress_;
    const OnUpdate& on_update_;
    Statistics statistics_; // before light_, which reports into it
    Region region_;
    FilterSampler filter_;
    Media media_;
    DirectLight light_;
    FilmSums sums_;
    bool has_shafts_ = false;
    double surface_seconds_ = 0.0, shaft_seconds_ = 0.0;
    std::optional<Clock::time_point> last_update_;
};
} // namespace

Film render(const Scene& scene, const Camera& camera, const FrameConfig& config, Progress& progress,
            const OnUpdate& on_update) {
    return with_threads(config.thread_count,
                        [&] { return FrameRenderer(scene, camera, config, progress, on_update).render(); });
}
} // namespace tyndall::render
