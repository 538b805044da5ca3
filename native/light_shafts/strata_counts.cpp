// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/strata_counts.hpp"
#include "light_shafts/prepared_lights.hpp"
#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

namespace tyndall::light_shafts {
static double mean(const Rgb& radiance) {
    const double value = (double{radiance.x} + radiance.y + radiance.z) / 3.0;
    return std::isfinite(value) ? value : 0.0;
}

std::uint32_t strata_for_error(double deviation, double error, std::uint32_t most) {
    constexpr double order = 0.75;
    const double count = std::pow(deviation / error, 1.0 / order);
    if (!(count < most)) // an infinity, too
        return most;
    return std::min(most, std::bit_ceil(static_cast<std::uint32_t>(std::ceil(std::max(count, 1.0)))));
}

/// Mean over rays of the variance between the strata of one light, each as if it were the whole light.
static double variance_of(const PreparedLights& pilot, const LightBeams& light, Block& block, double& light_sum) {
    const std::size_t ray_count = block.rays.size();
    std::vector<double> sum(ray_count), sum_of_squares(ray_count);
    const auto strata = static_cast<double>(light.stratum_count());
    for (std::size_t stratum = 0; stratum < light.stratum_count(); ++stratum) {
        block.radiance.assign(ray_count, Rgb(0.0f));
        block.lit_length_m.assign(ray_count, 0.0f);
        pilot.add(light, stratum, block);
        pilot.add_inside(light, block, block.radiance, 1.0f / static_cast<float>(light.stratum_count()));
        for (std::size_t ray = 0; ray < ray_count; ++ray) {
            const double value = strata * mean(block.radiance[ray]);
            sum[ray] += value;
            sum_of_squares[ray] += value * value;
        }
    }
    double variance = 0.0;
    for (std::size_t ray = 0; ray < ray_count; ++ray) {
        variance += std::max(0.0, sum_of_squares[ray] - sum[ray] * sum[ray] / strata) / std::max(strata - 1.0, 1.0);
        light_sum += sum[ray] / strata;
    }
    return variance / static_cast<double>(std::max<std::size_t>(ray_count, 1));
}

StrataCounts count_strata(const Scene& scene, const Media& media, const View& view, std::span<const ViewRay> rays,
                          const Config& config, Progress& progress) {
    constexpr std::uint32_t pilot_strata = 4, pilot_directions = 16;
    constexpr std::uint32_t usual_times = 4; // as many: where these are too many, so is the pilot
    constexpr std::size_t pilot_rays = 256;
    StrataCounts most, few;
    RowsCounts usual;
    for (const Light& light : scene.lights()) {
        most.of_light.push_back(has_size(light) ? config.light_samples : 1);
        few.of_light.push_back(std::min(most.of_light.back(), pilot_strata));
        if (light.kind != LightKind::Sun && light.scatters_in_media && light.strength != Rgb(0.0f)) {
            usual.lamps += 1;
            usual.lamp_samples += std::min(most.of_light.back(), usual_times * pilot_strata);
        }
    }
    most.of_world = config.world_samples;
    few.of_world = std::min(config.world_samples, pilot_directions);
    if (!scene.world().is_black())
        usual.world_samples = std::min(config.world_samples, usual_times * pilot_directions);
    const bool has_pilot = config.adapts_strata && (most.of_light != few.of_light || most.of_world != few.of_world);
    few.left = most.left = find_left(scene, media, config, usual);
    if (!has_pilot)
        return most;

    few.shares.assign(scene.lights().size(), 0.0f); // as few cells as can be, where something stands in a lamp
    Statistics ignored;                             // the frame's own preparation reports
    std::vector<ScatteringLight> lights = find_scattering_lights(scene, media, config, few, ignored);
    std::vector<ViewRay> some;
    const std::size_t step = std::max<std::size_t>(1, rays.size() / pilot_rays);
    for (std::size_t ray = step / 2; ray < rays.size(); ray += step)
        some.push_back(rays[ray]);
    Config coarse = config;
    coarse.method = config.method == Method::Exact ? Method::Exact : Method::Epipolar;
    coarse.resolution = 256; // of a whole light; 128 lines for each of 4 strata
    PreparedLights pilot{.media = media, .lights = {}, .statistics = {}};
    pilot.prepare(scene, view, some, std::move(lights), coarse, progress);

    Block block;
    std::vector<std::uint32_t> all(some.size());
    std::iota(all.begin(), all.end(), 0u);
    pilot.gather(some, all, block);
    double frame_sum = 0.0;
    std::vector<double> deviations, sums;
    for (const LightBeams& light : pilot.lights) {
        progress.poll();
        sums.push_back(-frame_sum);
        deviations.push_back(std::sqrt(variance_of(pilot, light, block, frame_sum)));
        sums.back() += frame_sum;
    }
    const double frame_mean = frame_sum / static_cast<double>(std::max<std::size_t>(some.size(), 1));
    const auto with_size = static_cast<double>(
        std::ranges::count_if(pilot.lights, [](const LightBeams& light) { return light.stratum_count() > 1; }));
    const double error = double{config.error_target} * frame_mean / std::sqrt(std::max(with_size, 1.0));
    StrataCounts counts = few;
    for (std::size_t index = 0; index < pilot.lights.size(); ++index) {
        const std::size_t light = pilot.lights[index].light;
        const bool is_world = light == scene.lights().size();
        if (!is_world)
            counts.shares[light] = frame_sum > 0.0 ? static_cast<float>(sums[index] / frame_sum) : 1.0f;
        std::uint32_t& count = is_world ? counts.of_world : counts.of_light[light];
        // Never fewer than the pilot had: it may have missed a penumbra.
        count = std::max(count,
                         strata_for_error(deviations[index], error, is_world ? most.of_world : most.of_light[light]));
    }
    return counts;
}
} // namespace tyndall::light_shafts
