// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/heterogeneity.hpp"
#include "core/parallel.hpp"
#include "light_shafts/heterogeneity_kernel.hpp"
#include "light_shafts/turns.hpp"
#include <algorithm>
#include <cmath>
#include <numeric>

namespace tyndall::light_shafts {
static float least_channel(const Rgb& value) { return std::min({value.x, value.y, value.z}); }

AirStepping::AirStepping(const Media& media, std::span<const MediumSegment> segments, std::uint32_t step_count,
                         float offset, float most_depth)
    : media_(&media), segments_(segments), step_count_(step_count), offset_(offset) {
    float depth = 0.0f, length_m = 0.0f;
    for (const MediumSegment& segment : segments) {
        const float sigma_t = least_channel(media.sigma_t_per_m(segment.set));
        float within_m = segment.far_m - segment.near_m;
        if (sigma_t * within_m > most_depth - depth)
            within_m = std::max(0.0f, most_depth - depth) / sigma_t;
        depth += sigma_t * within_m;
        length_m += within_m;
    }
    step_m_ = length_m / static_cast<float>(step_count);
}

void AirStepping::find_points(std::span<float> at_m) const {
    if (segments_.size() == 1) {
        const float first_m = segments_.front().near_m + offset_ * step_m_;
        for (std::uint32_t step = 0; step < at_m.size(); ++step)
            at_m[step] = first_m + static_cast<float>(step) * step_m_;
        return;
    }
    for_each_step([&](std::uint32_t step, const MediumSegment& segment, float within_m, const Rgb&) {
        at_m[step] = segment.near_m + within_m;
    });
}

float AirStepping::steps_before(float distance_m) const {
    float length_m = 0.0f;
    for (const MediumSegment& segment : segments_) {
        if (distance_m <= segment.far_m) {
            length_m += std::max(distance_m - segment.near_m, 0.0f);
            break;
        }
        length_m += segment.far_m - segment.near_m;
    }
    return std::min(length_m / step_m_, static_cast<float>(step_count_));
}

void AirStepping::add_share(float near_m, float far_m, float weight, std::span<float> shares) const {
    const float begin = steps_before(near_m), end = steps_before(far_m);
    if (!(begin < end))
        return;
    const auto first = static_cast<std::size_t>(begin),
               last = std::min(static_cast<std::size_t>(end), shares.size() - 1);
    if (first == last) {
        shares[first] += weight * (end - begin);
        return;
    }
    shares[first] += weight * (static_cast<float>(first + 1) - begin);
    for (std::size_t step = first + 1; step < last; ++step)
        shares[step] += weight;
    shares[last] += weight * (end - static_cast<float>(last));
}

namespace {
/// The steps of a block of rays, and what each of them scatters.
struct Steps {
    std::vector<AirStepping> of_ray;
    std::vector<float> weights; ///< Per ray and step; sums over the lights.
    std::vector<float> shares;  ///< Lit, of the current ray and light.
    std::vector<float> at_m;    ///< Of the current ray.
    LitRows lit;
    std::vector<ScatterPiece> pieces;
};

/// What a sun scatters to the camera per metre of a step, if it were lit; mean over the channels.
void add_directional(const ViewRay& ray, std::span<const MediumSegment> segments, const DirectionalScatter& light,
                     float strata_weight, Steps& steps, std::span<float> weights) {
    steps.pieces.clear();
    light.append_pieces(ray, segments, steps.pieces);
    auto first = steps.at_m.begin();
    for (std::size_t piece = 0; piece < steps.pieces.size(); ++piece) {
        const bool is_last = piece + 1 == steps.pieces.size();
        const auto end =
            is_last ? steps.at_m.end() : std::upper_bound(first, steps.at_m.end(), steps.pieces[piece].far_m);
        const auto begin = static_cast<std::size_t>(first - steps.at_m.begin());
        const auto count = static_cast<std::size_t>(end - first);
        air_steps::add_piece(steps.pieces[piece], strata_weight,
                             {.at_m = steps.at_m.data() + begin,
                              .shares = steps.shares.data() + begin,
                              .weights = weights.data() + begin,
                              .count = count});
        first = end;
    }
}

/// The same of a lamp. The inverse square is integrated over the step, in the angle in which the lamp sees it; the rest is
/// that of its point, with the step's medium all the way to the lamp.
void add_local(const Media& media, const ViewRay& ray, const LightSample& light, bool attenuates_light,
               float strata_weight, const AirStepping& stepping, std::span<const float> shares,
               std::span<float> weights) {
    const vec3 foot_way = light.position - ray.origin;
    const float foot_m = glm::dot(foot_way, ray.direction);
    const float across2 =
        std::max(glm::dot(foot_way, foot_way) - foot_m * foot_m, 1e-12f * glm::dot(foot_way, foot_way));
    const float across_m = std::sqrt(across2 + light.softening_m2);
    stepping.for_each_step([&](std::uint32_t step, const MediumSegment& segment, float within_m, Rgb depth) {
        if (shares[step] == 0.0f)
            return;
        const float at_m = segment.near_m + within_m, half_m = 0.5f * stepping.step_m();
        const float begin = at_m - half_m - foot_m, end = at_m + half_m - foot_m;
        const float angle = std::atan2((end - begin) * across_m, across_m * across_m + begin * end);
        const vec3 from_light = ray.origin + at_m * ray.direction - light.position;
        const float distance_m = glm::length(from_light);
        const vec3 direction = from_light / distance_m;
        if (attenuates_light)
            depth += media.sigma_t_per_m(segment.set) * distance_m;
        const Rgb source = intensity_w_per_sr(light, direction) *
                           media.scatter_per_m_sr(segment.set, -glm::dot(direction, ray.direction)) * glm::exp(-depth);
        weights[step] += strata_weight * shares[step] * average(source) * angle / (across_m * stepping.step_m());
    });
}

/// Light beyond this depth, a thousandth, counts for the texture no more.
constexpr float most_depth_of_light = 7.0f;
/// Strata of a light that a ray's texture is asked for: they change its weights only, and those in penumbras.
constexpr std::size_t most_strata = 4;

class TexturedBlock {
public:
    TexturedBlock(const PreparedLights& prepared, const AirTexture& air, const Turn& turn)
        : prepared_(prepared), air_(air), turn_(turn) {}

    void find(Block& block, Steps& steps, std::span<float> heterogeneity) const {
        const Heterogeneity& wanted = air_.heterogeneity();
        const bool is_whole = wanted.weighting == Heterogeneity::Weighting::WholeRay;
        const std::size_t step_count = wanted.step_count;
        steps.of_ray.clear();
        steps.at_m.resize(step_count);
        steps.weights.assign(block.rays.size() * step_count, is_whole ? 1.0f : 0.0f);
        for (std::size_t ray = 0; ray < block.rays.size(); ++ray)
            steps.of_ray.emplace_back(prepared_.media, block.segments_of(ray), wanted.step_count, offset(),
                                      is_whole ? std::numeric_limits<float>::infinity() : most_depth_of_light);
        if (!is_whole)
            for (const LightBeams& light : prepared_.lights)
                add(light, block, steps);
        for (std::size_t ray = 0; ray < block.rays.size(); ++ray) {
            const auto weights = std::span<const float>(steps.weights).subspan(ray * step_count, step_count);
            if (std::ranges::all_of(weights, [](float weight) { return weight == 0.0f; }))
                continue;
            const AirStepping& stepping = steps.of_ray[ray];
            stepping.find_points(steps.at_m);
            heterogeneity[block.target[ray]] = air_.mean({.origin = block.rays[ray].origin,
                                                          .direction = block.rays[ray].direction,
                                                          .at_m = steps.at_m,
                                                          .weights = weights,
                                                          .step_m = stepping.step_m()});
        }
    }

private:
    /// Where in its steps a pass looks: those of a pixel's passes fill the steps evenly.
    [[nodiscard]] float offset() const {
        return (static_cast<float>(spread(turn_.index, turn_.count)) + 0.5f) / static_cast<float>(turn_.count);
    }
    void add(const LightBeams& light, Block& block, Steps& steps) const {
        const Deal mine = deal(light.stratum_count(), turn_);
        const std::size_t stride = (mine.last - mine.first + most_strata - 1) / most_strata;
        for (std::size_t index = mine.first; index < mine.last; index += stride) {
            const std::size_t first = spread(index, light.stratum_count()) * light.parts;
            for (const Beam& beam : std::span(light.beams).subspan(first, light.parts))
                add(beam, mine.weight * static_cast<float>(stride), block, steps);
        }
    }
    void add(const Beam& beam, float strata_weight, Block& block, Steps& steps) const {
        steps.lit.clear();
        if (beam.local) {
            if (block.local.is_empty())
                block.local.assign(prepared_.media, block.rays, block.first_segment, block.segments);
            beam.local->lit_intervals(block.local, beam.visibility.get(), steps.lit);
        } else {
            beam.visibility->lit_intervals(block.rays, steps.lit);
        }
        const std::size_t step_count = air_.heterogeneity().step_count;
        for (std::size_t ray = 0; ray < block.rays.size(); ++ray) {
            const std::span<const LitInterval> lit = steps.lit.of_ray(ray);
            if (lit.empty())
                continue;
            const AirStepping& stepping = steps.of_ray[ray];
            steps.shares.assign(step_count, 0.0f);
            for (const LitInterval& interval : lit)
                stepping.add_share(interval.near_m, interval.far_m, average(interval.transmittance), steps.shares);
            const auto weights = std::span(steps.weights).subspan(ray * step_count, step_count);
            if (beam.directional) {
                stepping.find_points(steps.at_m);
                add_directional(block.rays[ray], block.segments_of(ray), *beam.directional, strata_weight, steps,
                                weights);
            } else {
                add_local(prepared_.media, block.rays[ray], beam.sample, prepared_.attenuates_light, strata_weight,
                          stepping, steps.shares, weights);
            }
        }
    }

    const PreparedLights& prepared_;
    const AirTexture& air_;
    Turn turn_;
};
} // namespace

std::vector<float> Shafts::find_heterogeneity(std::span<const ViewRay> rays, const AirTexture& air,
                                              const Progress& progress, Turn turn) const {
    std::vector<float> heterogeneity(rays.size(), dark_air);
    // As scatter() asks: neighbours in the picture read different rows.
    std::vector<std::uint32_t> order;
    if (prepared_->finest && air.heterogeneity().weighting == Heterogeneity::Weighting::LitParts)
        order = prepared_->finest->coherent_order(rays, progress);
    if (order.empty()) {
        order.resize(rays.size());
        std::iota(order.begin(), order.end(), 0u);
    }
    const TexturedBlock textured(*prepared_, air, turn);
    constexpr std::size_t rays_per_block = 256;
    parallel_blocks(rays.size(), rays_per_block, progress, [&](std::size_t begin, std::size_t end) {
        thread_local Block block;
        thread_local Steps steps;
        prepared_->gather(rays, std::span(order).subspan(begin, end - begin), block);
        textured.find(block, steps, heterogeneity);
    });
    return heterogeneity;
}
} // namespace tyndall::light_shafts
