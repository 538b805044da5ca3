// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/frame_air.hpp"
#include "core/parallel.hpp"
#include <algorithm>
#include <chrono>
#include <numeric>

namespace tyndall::render {
using light_shafts::dark_air;
using light_shafts::ViewRay;

/// The squares whose middles lie around the middles of the pixels [begin, end): those before and after them, of as many
/// as there are in the frame.
static std::pair<std::uint32_t, std::uint32_t> squares_around(std::uint32_t begin, std::uint32_t end,
                                                              std::uint32_t frame_px, std::uint32_t side) {
    const std::uint32_t before = begin < side / 2 ? 0 : (begin - side / 2) / side;
    const std::uint32_t after = end - 1 < side / 2 ? 0 : (end - 1 - side / 2) / side + 1;
    return {before, std::min(after, (frame_px - 1) / side) + 1};
}

FrameAir::FrameAir(const Heterogeneity& heterogeneity, const Camera& camera, const Region& region, bool fills_dark,
                   const Progress& progress)
    : air_(heterogeneity, progress), air_of_whole_ray_(air_.weighted(Heterogeneity::Weighting::WholeRay)),
      camera_(camera), air_camera_(camera.of_air()), region_(region), upsampling_(heterogeneity.upsampling),
      fills_dark_(fills_dark), squares_{0, 0, 0, 0} {
    if (upsampling_ == 1)
        return;
    std::tie(squares_.x0, squares_.x1) = squares_around(region.x0, region.x1, camera.width_px, upsampling_);
    std::tie(squares_.y0, squares_.y1) = squares_around(region.y0, region.y1, camera.height_px, upsampling_);
    const Region seen{std::min(region.x0, middle_px(squares_.x0, camera.width_px)),
                      std::min(region.y0, middle_px(squares_.y0, camera.height_px)),
                      std::max(region.x1, middle_px(squares_.x1 - 1, camera.width_px) + 1),
                      std::max(region.y1, middle_px(squares_.y1 - 1, camera.height_px) + 1)};
    for (const Region& margin :
         {Region{seen.x0, seen.y0, seen.x1, region.y0}, Region{seen.x0, region.y1, seen.x1, seen.y1},
          Region{seen.x0, region.y0, region.x0, region.y1}, Region{region.x1, region.y0, seen.x1, region.y1}})
        if (margin.x0 < margin.x1 && margin.y0 < margin.y1)
            margins_.push_back({.pixels = margin, .parts = {}});
}

std::uint32_t FrameAir::middle_px(std::uint32_t square, std::uint32_t frame_px) const {
    return std::min(square * upsampling_ + upsampling_ / 2, frame_px - 1);
}

void FrameAir::begin_pass(const ViewPath& path, const FilterSampler& filter, const SurfacePass::Config& config,
                          std::uint32_t sample_index, const WaitingParts& waiting, const Progress& progress) {
    for (auto& [pixels, parts] : margins_) {
        parts.clear();
        const std::uint32_t rows = pixels.y1 - pixels.y0;
        SurfacePass(path, camera_, pixels, filter, config)
            .find_parts({.sample_index = sample_index, .first_row = 0, .end_row = rows}, parts, progress);
    }
    const std::size_t squares_per_line = squares_.x1 - squares_.x0, line_count = squares_.y1 - squares_.y0;
    /// visit(square, rays of a part of the frame) for those of a square's middle pixel, of the lines [begin, end).
    const auto for_rays = [&](std::size_t begin, std::size_t end, const auto& visit) {
        for (std::size_t line = begin; line < end; ++line) {
            const std::uint32_t y = middle_px(squares_.y0 + static_cast<std::uint32_t>(line), camera_.height_px);
            for (std::uint32_t index = 0; index < squares_per_line; ++index) {
                const std::uint32_t x = middle_px(squares_.x0 + index, camera_.width_px);
                const auto visit_in = [&](const Region& pixels, const WaitingParts& parts) {
                    if (x < pixels.x0 || pixels.x1 <= x || y < pixels.y0 || pixels.y1 <= y)
                        return;
                    const std::size_t pixel = std::size_t{y - pixels.y0} * (pixels.x1 - pixels.x0) + (x - pixels.x0);
                    const std::size_t first = parts.first[pixel], count = parts.first[pixel + 1] - first;
                    visit(line * squares_per_line + index, std::span(parts.rays).subspan(first, count));
                };
                visit_in(region_, waiting);
                for (const auto& [pixels, parts] : margins_)
                    visit_in(pixels, parts);
            }
        }
    };
    constexpr std::size_t lines_per_block = 8;
    first_of_square_.assign(line_count * squares_per_line + 1, 0);
    parallel_blocks(line_count, lines_per_block, progress, [&](std::size_t begin, std::size_t end) {
        for_rays(begin, end, [&](std::size_t square, std::span<const ViewRay> rays) {
            first_of_square_[square + 1] += static_cast<std::uint32_t>(rays.size());
        });
    });
    std::partial_sum(first_of_square_.begin(), first_of_square_.end(), first_of_square_.begin());
    square_rays_.resize(first_of_square_.back());
    square_far_m_.resize(first_of_square_.back() + PixelsBetweenSquares::padding);
    parallel_blocks(line_count, lines_per_block, progress, [&](std::size_t begin, std::size_t end) {
        std::size_t next = first_of_square_[begin * squares_per_line];
        for_rays(begin, end, [&](std::size_t, std::span<const ViewRay> rays) {
            for (const ViewRay& ray : rays) {
                square_far_m_[next] = ray.far_m;
                square_rays_[next++] = ray;
            }
        });
    });
}

namespace {
/// Adds the time until it goes out of scope.
class Stopwatch {
public:
    explicit Stopwatch(double& seconds) : seconds_(seconds) {}
    Stopwatch(const Stopwatch&) = delete;
    Stopwatch& operator=(const Stopwatch&) = delete;
    ~Stopwatch() { seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

private:
    double& seconds_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};
} // namespace

void FrameAir::report(Statistics& statistics) const {
    statistics.stages.push_back({"heterogeneity", seconds_});
    statistics.count("heterogeneity: rays", static_cast<double>(asked_count_));
}

void FrameAir::ask_squares(const light_shafts::Shafts& shafts, light_shafts::Turn turn, const Progress& progress) {
    const Stopwatch stopwatch(seconds_);
    picture_ = shafts.picture_air(air_camera_, air_, turn);
    asked_count_ += square_rays_.size();
    has_one_each_ = true;
    for (std::size_t square = 0; square < first_of_square_.size(); ++square)
        has_one_each_ = has_one_each_ && first_of_square_[square] == square;
    square_heterogeneity_.assign(square_rays_.size() + PixelsBetweenSquares::padding, dark_air);
    shafts.find_heterogeneity(square_rays_, air_, std::span(square_heterogeneity_).first(square_rays_.size()), progress,
                              turn, picture_.get());
}

std::pair<std::uint32_t, float> FrameAir::square_before(std::uint32_t pixel, std::uint32_t first,
                                                        std::uint32_t end) const {
    const float at = std::clamp((static_cast<float>(pixel) - static_cast<float>(upsampling_ / 2)) *
                                    (1.0f / static_cast<float>(upsampling_)),
                                static_cast<float>(first), static_cast<float>(end - 1));
    const auto before = static_cast<std::uint32_t>(at);
    return std::pair{before, at - static_cast<float>(before)};
}

float FrameAir::carried_over(std::uint32_t x, std::uint32_t y, float far_m) const {
    const auto [before_x, share_x] = square_before(x, squares_.x0, squares_.x1);
    const auto [before_y, share_y] = square_before(y, squares_.y0, squares_.y1);
    float sum = 0.0f, weight_sum = 0.0f;
    for (std::uint32_t corner = 0; corner < 4; ++corner) {
        const bool is_right = corner % 2 == 1, is_upper = corner / 2 == 1;
        const float near = (is_right ? share_x : 1.0f - share_x) * (is_upper ? share_y : 1.0f - share_y);
        if (near <= 0.0f)
            continue;
        const std::size_t square = std::size_t{before_y - squares_.y0 + is_upper} * (squares_.x1 - squares_.x0) +
                                   before_x - squares_.x0 + is_right;
        for (std::size_t part = first_of_square_[square]; part < first_of_square_[square + 1]; ++part) {
            const float agrees = agreement(far_m, square_rays_[part].far_m);
            if (!(agrees > 0.0f) || square_heterogeneity_[part] == dark_air)
                continue;
            const float weight = near * agrees;
            sum += weight * square_heterogeneity_[part];
            weight_sum += weight;
        }
    }
    return weight_sum > least_neighbour_weight ? sum / weight_sum : dark_air;
}

PixelsBetweenSquares FrameAir::between_squares(std::uint32_t x, std::uint32_t y) const {
    const auto [before_y, share_y] = square_before(y, squares_.y0, squares_.y1);
    const std::size_t squares_per_line = squares_.x1 - squares_.x0;
    const std::size_t lower = (before_y - squares_.y0) * squares_per_line,
                      upper = (std::min(before_y + 1, squares_.y1 - 1) - squares_.y0) * squares_per_line;
    return {.x = x,
            .side = upsampling_,
            .first_square = squares_.x0,
            .end_square = squares_.x1,
            .lower_far_m = &square_far_m_[lower],
            .upper_far_m = &square_far_m_[upper],
            .lower_heterogeneity = &square_heterogeneity_[lower],
            .upper_heterogeneity = &square_heterogeneity_[upper],
            .share_y = share_y};
}

void FrameAir::find(const light_shafts::Shafts& shafts, light_shafts::Turn turn, const WaitingParts& waiting,
                    std::size_t first_pixel, std::size_t end_pixel, std::span<const Rgb> radiance,
                    std::span<float> heterogeneity, const Progress& progress) {
    const Stopwatch stopwatch(seconds_);
    const std::size_t first = waiting.first[first_pixel];
    const std::uint32_t width = region_.x1 - region_.x0;
    constexpr std::size_t pixels_per_block = 1 << 11;
    asked_count_ += parallel_sum(
        end_pixel - first_pixel, pixels_per_block, std::size_t{0}, progress, [&](std::size_t begin, std::size_t end) {
            std::size_t asked_count = 0;
            if (upsampling_ == 1) {
                for (std::size_t part = waiting.first[first_pixel + begin]; part < waiting.first[first_pixel + end];
                     ++part) {
                    const bool is_asked = fills_dark_ || radiance[part - first] != Rgb(0.0f);
                    heterogeneity[part - first] = is_asked ? dark_air : 1.0f;
                    asked_count += is_asked ? 1 : 0;
                }
                return asked_count;
            }
            for (std::size_t pixel = first_pixel + begin, next; pixel < first_pixel + end; pixel = next) {
                const auto x = static_cast<std::uint32_t>(region_.x0 + pixel % width),
                           y = static_cast<std::uint32_t>(region_.y0 + pixel / width);
                // Pixels of one ray each, to the end of the line.
                const std::size_t line_end = std::min(first_pixel + end, (pixel / width + 1) * width);
                for (next = pixel; next < line_end && waiting.first[next + 1] - waiting.first[next] == 1;)
                    ++next;
                if (has_one_each_ && next > pixel) {
                    const std::size_t part = waiting.first[pixel], count = next - pixel;
                    asked_count += carry_over(between_squares(x, y), std::span(waiting.rays).subspan(part, count),
                                              radiance.subspan(part - first, count), fills_dark_,
                                              heterogeneity.subspan(part - first, count));
                    continue;
                }
                next = pixel + 1;
                for (std::size_t part = waiting.first[pixel]; part < waiting.first[pixel + 1]; ++part) {
                    float& value = heterogeneity[part - first];
                    value = !fills_dark_ && radiance[part - first] == Rgb(0.0f)
                                ? 1.0f
                                : carried_over(x, y, waiting.rays[part].far_m);
                    asked_count += value == dark_air ? 1 : 0;
                }
            }
            return asked_count;
        });
    const std::span<const ViewRay> rays = std::span(waiting.rays).subspan(first, heterogeneity.size());
    std::size_t dark_count = shafts.find_heterogeneity(rays, air_, heterogeneity, progress, turn, picture_.get());
    // Dark rays that have to have a texture, and those whose light came from strata that neighbours were asked for.
    if (dark_count > 0)
        dark_count = shafts.find_heterogeneity(rays, air_of_whole_ray_, heterogeneity, progress, turn);
    if (dark_count > 0)
        std::ranges::replace(heterogeneity, dark_air, 1.0f); // no media
}
} // namespace tyndall::render
