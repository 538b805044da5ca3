// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/drawn_shafts.hpp"
#include <algorithm>

namespace tyndall::render {
static constexpr std::uint32_t draws_per_pixel = 64; // at least
static constexpr std::uint32_t usual_draws = 4;
static constexpr double draw_s = 3e-6;        // and a camera ray's share of surfaces for each of usual_draws
static constexpr double grid_draw_s = 1.5e-6; // more, where light passes density grids
static constexpr double most_times = 4.0;     // as long as that

std::uint32_t shaft_draws(const light_shafts::Config& config, std::uint32_t pixel_samples) {
    return config.walks_maps ? usual_draws
                             : std::max(usual_draws, (draws_per_pixel + pixel_samples - 1) / pixel_samples);
}

light_shafts::RowsLimit rows_limit(const Scene& scene, const Media& media, const light_shafts::Config& config,
                                   double ray_count, std::uint32_t pixel_samples) {
    const auto is_edited = [](const Light& light) { return !light.occluder_edits.empty(); };
    if (config.method == light_shafts::Method::Exact || config.resolution != 0 ||
        std::ranges::any_of(scene.lights(), is_edited))
        return {};
    const double each_s = draw_s + (media.grids().is_empty() ? 0.0 : grid_draw_s);
    return {.most_s = most_times * each_s * shaft_draws(config, pixel_samples) * ray_count, .ray_count = ray_count};
}
} // namespace tyndall::render
