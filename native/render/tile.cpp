// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/tile.hpp"
#include "core/errors.hpp"
#include "render/pixel_noise.hpp"
#include <algorithm>

namespace tyndall::render {
/// Strata and the world's light are shared over 2 pixels, functions look at one pixel more to each side, and rays have the
/// company of their square. Where pixels may stop, all of that decides after each round which samples there will be.
static std::uint32_t margin_px(const FrameConfig& config) {
    const std::uint32_t rounds =
        config.noise_threshold > 0.0f ? config.taken_samples() / samples_per_round(config.taken_samples()) : 1;
    return 2 * SurfacePass::square_px * rounds;
}

FrameConfig grown_tile(const FrameConfig& config, const Region& tile, const Camera& camera) {
    require(!config.heterogeneity || config.heterogeneity->upsampling == 1, "heterogeneity's upsampling is ",
            config.heterogeneity ? config.heterogeneity->upsampling : 1,
            ": how it is carried over depends on the whole frame; tiles need 1");
    require(!config.keeps_unstyled, "a tile's picture is not kept for changes of its transfer functions");
    FrameConfig grown = config;
    const std::uint32_t margin = margin_px(config);
    grown.region = Region{tile.x0 - std::min(tile.x0, margin), tile.y0 - std::min(tile.y0, margin),
                          std::min(tile.x1 + margin, camera.width_px), std::min(tile.y1 + margin, camera.height_px)};
    return grown;
}

Film cropped(Film film, const Region& from, const Region& to) {
    Film result{
        .width_px = to.x1 - to.x0, .height_px = to.y1 - to.y0, .planes = {}, .data_planes = {}, .statistics = {}};
    result.statistics = std::move(film.statistics);
    const auto part_of = [&](const std::vector<float>& values, std::size_t channels) {
        std::vector<float> part;
        part.reserve(std::size_t{result.width_px} * result.height_px * channels);
        for (std::uint32_t y = to.y0; y < to.y1; ++y) {
            const auto row =
                values.begin() +
                static_cast<std::ptrdiff_t>((std::size_t{y - from.y0} * film.width_px + (to.x0 - from.x0)) * channels);
            part.insert(part.end(), row, row + static_cast<std::ptrdiff_t>(result.width_px * channels));
        }
        return part;
    };
    for (const Plane& plane : film.planes)
        result.planes.push_back({plane.pass, part_of(plane.values, layout(plane.pass).channel_count)});
    for (const NamedPlane& plane : film.data_planes)
        result.data_planes.push_back({plane.name, plane.channel_count, part_of(plane.values, plane.channel_count)});
    return result;
}
} // namespace tyndall::render
