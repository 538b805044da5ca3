// SPDX-License-Identifier: GPL-3.0-or-later
// How many draws of what glows a part of a view ray is worth, and by which strategies: a few parts tell.
#include "core/parallel.hpp"
#include "core/random.hpp"
#include "render/fog_glow.hpp"
#include <algorithm>
#include <bit>

namespace tyndall::render {
static constexpr std::size_t most_parts = 512;
static constexpr std::uint32_t draws_of_part = 8;
/// Of a draw of a triangle, what it takes to draw a direction, too, about: results must not depend on the clock.
static constexpr double direction_cost = 0.6;

struct FogGlow::Noise {
    double variance = 0.0, square = 0.0; ///< Of one draw; of what parts have.
    Noise& operator+=(const Noise& other) {
        variance += other.variance, square += other.square;
        return *this;
    }
};

FogGlow::Noise FogGlow::noise_of(std::span<const light_shafts::ViewRay> parts, const Progress& progress) const {
    const std::size_t count = std::min(parts.size(), most_parts);
    return parallel_sum(count, 32, Noise{}, progress, [&](std::size_t begin, std::size_t end) {
        MediaLine line;
        std::vector<Found> drawn;
        Noise found;
        for (std::size_t index = begin; index < end; ++index) {
            assign(line, parts[index * parts.size() / count]);
            double sum = 0.0, squares = 0.0;
            for (std::uint32_t number = 0; !line.is_empty() && number < draws_of_part; ++number) {
                drawn.clear();
                draw(line, {hash(static_cast<std::uint32_t>(index), number), 0, 0}, drawn);
                double value = 0.0;
                for (const Found& one : drawn)
                    value += average(one.radiance);
                sum += value, squares += value * value;
            }
            const double variance = std::max(0.0, squares - sum * sum / draws_of_part) / (draws_of_part - 1);
            found.variance += variance;
            found.square += std::max(0.0, sum * sum / (draws_of_part * draws_of_part) - variance / draws_of_part);
        }
        return found;
    });
}

void FogGlow::prepare(std::span<const light_shafts::ViewRay> parts, const Wanted& wanted, const Progress& progress) {
    draw_count_ = 1;
    if (wanted.is_coarse)
        return;
    Noise noise = noise_of(parts, progress);
    if (tree_ != nullptr && !has_met_alone_) {
        draws_directions_ = true;
        const Noise with_directions = noise_of(parts, progress);
        draws_directions_ = with_directions.variance * (1.0 + direction_cost) < noise.variance;
        if (draws_directions_)
            noise = with_directions;
    }
    if (!(noise.variance > 0.0))
        return;
    const double error = wanted.error_target;
    const double needed = noise.variance / (noise.square * error * error * wanted.pixel_samples);
    draw_count_ =
        needed < most_draws ? std::bit_ceil(static_cast<std::uint32_t>(std::max(1.0, std::ceil(needed)))) : most_draws;
}
} // namespace tyndall::render
