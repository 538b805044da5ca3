// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/edited_resolution.hpp"
#include <algorithm>
#include <cmath>
#include <numeric>

namespace tyndall::light_shafts {
/// Measured in an atrium and in a forest of leaves, 13 / 20 over the texels; and as much again for thin occluders.
static constexpr float error_times_texels = 30.0f;

float error_target_of_map(float texels) { return error_times_texels / texels; }
float texels_of_map(float error_target) {
    return std::clamp(error_times_texels / error_target, 16.0f, most_texels_of_map);
}

/// What the beam scatters along the block's rays, mean over the channels.
static std::vector<double> scattered(const Beam& beam, const Visibility& visibility, Block& block) {
    block.radiance.assign(block.rays.size(), Rgb(0.0f));
    if (beam.local)
        beam.local->add_scattered(block.local, &visibility, block.radiance, {}, {});
    else
        visibility.add_scattered(block.rays, block.pieces, block.radiance, {});
    std::vector<double> result;
    for (const Rgb& radiance : block.radiance)
        result.push_back((double{radiance.x} + radiance.y + radiance.z) / 3.0);
    return result;
}

float measured_error_target(const PreparedLights& prepared, const Beam& beam, std::span<const ViewRay> rays,
                            float error_target, const MakeEdited& make) {
    constexpr std::size_t pilot_rays = 4096;
    constexpr float least_texels = 2048.0f, order = 0.75f;
    const float most_texels = texels_of_map(error_target);
    if (most_texels <= least_texels)
        return error_target;
    std::vector<ViewRay> some;
    const std::size_t step = std::max<std::size_t>(1, rays.size() / pilot_rays);
    for (std::size_t ray = step / 2; ray < rays.size(); ray += step)
        some.push_back(rays[ray]);
    std::vector<std::uint32_t> all(some.size());
    std::iota(all.begin(), all.end(), 0u);
    Block block;
    prepared.gather(some, all, block);
    if (beam.local)
        block.local.assign(prepared.media, block.rays, block.first_segment, block.segments);
    else
        for (std::size_t ray = 0; ray < block.rays.size(); ++ray) {
            beam.directional->append_pieces(block.rays[ray], block.segments_of(ray), block.pieces.pieces);
            block.pieces.end_ray();
        }
    const float texels = std::max(least_texels, most_texels / 4.0f);
    const auto at = [&](float resolution) {
        return scattered(beam, *make(static_cast<std::uint32_t>(resolution)), block);
    };
    const std::vector<double> coarse = at(0.5f * texels), fine = at(texels);
    double change = 0.0, sum = 0.0;
    for (std::size_t ray = 0; ray < fine.size(); ++ray) {
        change += (fine[ray] - coarse[ray]) * (fine[ray] - coarse[ray]);
        sum += fine[ray];
    }
    if (!(sum > 0.0))
        return error_target;
    const double error = std::sqrt(change / 3.0 * static_cast<double>(fine.size())) / sum;
    // Doubled or not: a map of which nothing else changes keeps its texels from frame to frame.
    float needed = texels;
    while (needed < most_texels && error * std::pow(texels / needed, order) > double{error_target})
        needed *= 2.0f;
    return needed >= most_texels ? error_target : std::max(error_target, error_target_of_map(needed));
}
} // namespace tyndall::light_shafts
