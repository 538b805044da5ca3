// SPDX-License-Identifier: GPL-3.0-or-later
// How many draws of what glows a part of a view ray is worth, and by which strategies: some pixels tell.
// Based on: as shadow_ray_counts.hpp, of which this is one more light: the number with the least noise in a fixed time.
#include "core/parallel.hpp"
#include "core/random.hpp"
#include "render/best_ray_counts.hpp"
#include "render/fog_glow.hpp"
#include <algorithm>

namespace tyndall::render {
static constexpr std::size_t most_pixels = 512;
static constexpr std::uint32_t draws_of_pixel = 8;
/// Of a draw of a triangle, in rays to the world, and what it takes to draw a direction, too, about: results must not depend
/// on the clock.
static constexpr double draw_cost = 7.0, direction_cost = 0.6;

std::vector<FogGlow::PilotLight> FogGlow::pilot_lights(std::span<const PilotPixel> pixels,
                                                       const Progress& progress) const {
    std::vector<PilotLight> lights(pixels.size());
    parallel_for(
        pixels.size(), progress,
        [&](std::size_t index) {
            MediaLine line;
            std::vector<Found> drawn;
            assign(line, pixels[index].part);
            double sum = 0.0, squares = 0.0;
            for (std::uint32_t number = 0; !line.is_empty() && number < draws_of_pixel; ++number) {
                drawn.clear();
                draw(line, {hash(static_cast<std::uint32_t>(index), number), 0, 0}, drawn);
                double value = 0.0;
                for (const Found& one : drawn)
                    value += average(one.radiance);
                sum += value, squares += value * value;
            }
            lights[index] = {sum / draws_of_pixel,
                             std::max(0.0, squares - sum * sum / draws_of_pixel) / (draws_of_pixel - 1)};
        },
        32);
    return lights;
}

void FogGlow::prepare(const PilotSamples& pilot, const Progress& progress) {
    draw_count_ = turn_ = 1;
    std::vector<PilotPixel> pixels;
    const std::size_t count = std::min(pilot.pixels.size(), most_pixels);
    for (std::size_t index = 0; index < count; ++index)
        pixels.push_back(pilot.pixels[index * pilot.pixels.size() / count]);
    std::vector<PilotLight> lights = pilot_lights(pixels, progress);
    double cost = draw_cost;
    if (tree_ != nullptr && !has_met_alone_) {
        const auto variance_of = [](std::span<const PilotLight> of_pixels) {
            double sum = 0.0;
            for (const PilotLight& light : of_pixels)
                sum += light.variance;
            return sum;
        };
        draws_directions_ = true;
        std::vector<PilotLight> with_directions = pilot_lights(pixels, progress);
        draws_directions_ = variance_of(with_directions) * (1.0 + direction_cost) < variance_of(lights);
        if (draws_directions_) {
            lights = std::move(with_directions);
            cost *= 1.0 + direction_cost;
        }
    }
    double frame_mean = 0.0;
    for (std::size_t index = 0; index < count; ++index)
        frame_mean += (pixels[index].brightness + lights[index].mean) / static_cast<double>(count);
    std::vector<PixelVariances> variances;
    for (std::size_t index = 0; index < count; ++index) {
        const double scale = pixels[index].brightness + lights[index].mean + darkest_share * frame_mean;
        if (scale > 0.0 && std::isfinite(scale))
            variances.push_back({pixels[index].variance / (scale * scale), {lights[index].variance / (scale * scale)}});
    }
    if (variances.empty())
        return;
    const RayCosts costs{.of_camera = pilot.cost, .of_light = {cost}};
    draw_count_ = std::min(best_ray_counts(variances, costs)[0], most_draws);
    turn_ = best_turns(variances, costs, {&draw_count_, 1}, pilot.longest_turn)[0];
}
} // namespace tyndall::render
