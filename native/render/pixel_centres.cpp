// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/pixel_centres.hpp"
#include "core/parallel.hpp"
#include "render/frame.hpp"
#include "render/pixel_samples.hpp"
#include <algorithm>
#include <array>

namespace tyndall::render {
static constexpr std::uint32_t row_px = DirectLight::most_points; ///< Rays that go side by side.

void see_pixel_centres(const ViewPath& path, const Camera& camera, const Region& region, const FrameConfig& config,
                       FilmSums& sums, DataSums* data, const Progress& progress) {
    DataPassConfig indices;
    if (data != nullptr)
        indices.bits = config.data.bits & index_pass_bits;
    if (!sums.wants(Pass::Depth) && !sums.wants(Pass::Position) && indices.bits == 0)
        return;
    const std::uint32_t width = region.x1 - region.x0, per_row = (width + row_px - 1) / row_px;
    const auto see_some = [&](std::size_t task) {
        const std::uint32_t y = region.y0 + static_cast<std::uint32_t>(task / per_row);
        const std::uint32_t first_x = region.x0 + static_cast<std::uint32_t>(task % per_row) * row_px;
        const std::size_t count = std::min(row_px, region.x1 - first_x);
        std::array<Ray, row_px> rays;
        std::array<std::uint32_t, row_px> seeds, targets;
        std::array<PathSample, row_px> samples;
        thread_local std::array<std::vector<MediumPart>, row_px> parts; // of which nobody asks for any
        thread_local std::vector<PathData> found(row_px);
        for (std::size_t i = 0; i < count; ++i) {
            const std::uint32_t x = first_x + static_cast<std::uint32_t>(i);
            rays[i] = pixel_ray(camera, x, y);
            seeds[i] = pixel_seed(camera, config.seed, x, y);
            targets[i] = ViewPath::nowhere;
            parts[i].clear(), found[i].clear();
        }
        path.walk(std::span(rays).first(count), std::span(seeds).first(count), 0, std::span(targets).first(count),
                  samples, parts, nullptr,
                  {std::span(found).first(indices.bits != 0 ? count : 0), indices.bits != 0 ? &indices : nullptr});
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t pixel = std::size_t{y - region.y0} * width + (first_x - region.x0) + i;
            sums.set_place(pixel, samples[i].depth_m, samples[i].position);
            if (indices.bits != 0 && found[i].has_surface)
                data->set_indices(pixel, found[i]);
        }
    };
    parallel_for(std::size_t{region.y1 - region.y0} * per_row, progress, see_some, 16);
}
} // namespace tyndall::render
