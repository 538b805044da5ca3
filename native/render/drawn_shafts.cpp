// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/drawn_shafts.hpp"
#include <algorithm>

namespace tyndall::render {
static constexpr double ray_s = 12e-6;    // of a camera ray: its surfaces and draws
static constexpr double most_times = 4.0; // as long as that

light_shafts::RowsLimit rows_limit(const Scene& scene, const Media& media, const light_shafts::Config& config,
                                   double ray_count) {
    const auto is_edited = [](const Light& light) { return !light.occluder_edits.empty(); };
    if (config.method != light_shafts::Method::Epipolar || config.resolution != 0 || config.walks_maps ||
        !media.grids().is_empty() || std::ranges::any_of(scene.lights(), is_edited))
        return {};
    return {.most_s = most_times * ray_s * ray_count, .ray_count = ray_count};
}
} // namespace tyndall::render
