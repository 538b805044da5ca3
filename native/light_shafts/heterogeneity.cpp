// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/heterogeneity.hpp"
#include "core/parallel.hpp"
#include "light_shafts/turns.hpp"
#include <algorithm>
#include <cmath>
#include <numeric>

namespace tyndall::light_shafts {
static float least_channel(const Rgb& value) { return std::min({value.x, value.y, value.z}); }

void AirStepping::assign(const Media& media, std::span<const MediumSegment> segments, std::uint32_t step_count,
                         float offset, float most_depth) {
    segments_ = segments;
    length_before_m_.assign(1, 0.0f);
    float depth = 0.0f, length_m = 0.0f;
    for (const MediumSegment& segment : segments) {
        const float sigma_t = least_channel(media.sigma_t_per_m(segment.set));
        float within_m = segment.far_m - segment.near_m;
        length_before_m_.push_back(length_before_m_.back() + within_m);
        if (sigma_t * within_m > most_depth - depth)
            within_m = std::max(0.0f, most_depth - depth) / sigma_t;
        depth += sigma_t * within_m;
        length_m += within_m;
    }
    step_m_ = length_m / static_cast<float>(step_count);
    at_m_.clear(), depths_.clear(), segment_of_.clear();
    std::size_t segment = 0;
    Rgb depth_before(0.0f), sigma_t = media.sigma_t_per_m(segments.front().set);
    for (std::uint32_t step = 0; step < step_count; ++step) {
        const float before_m = (static_cast<float>(step) + offset) * step_m_;
        while (segment + 1 < segments.size() && before_m > length_before_m_[segment + 1]) {
            depth_before += sigma_t * (segments[segment].far_m - segments[segment].near_m);
            sigma_t = media.sigma_t_per_m(segments[++segment].set);
        }
        const float within_m = before_m - length_before_m_[segment];
        at_m_.push_back(segments[segment].near_m + within_m);
        depths_.push_back(depth_before + sigma_t * within_m);
        segment_of_.push_back(static_cast<std::uint32_t>(segment));
    }
}

float AirStepping::steps_before(float distance_m) const {
    std::size_t segment = 0;
    while (segment + 1 < segments_.size() && distance_m > segments_[segment].far_m)
        ++segment;
    const float within_m =
        std::clamp(distance_m, segments_[segment].near_m, segments_[segment].far_m) - segments_[segment].near_m;
    return std::min((length_before_m_[segment] + within_m) / step_m_, static_cast<float>(at_m_.size()));
}

void AirStepping::add_share(float near_m, float far_m, float weight, std::span<float> shares) const {
    const float begin = steps_before(near_m), end = steps_before(far_m);
    if (!(begin < end))
        return;
    const auto first = static_cast<std::size_t>(begin),
               last = std::min(static_cast<std::size_t>(end), shares.size() - 1);
    for (std::size_t step = first; step <= last; ++step)
        shares[step] +=
            weight * (std::min(end, static_cast<float>(step + 1)) - std::max(begin, static_cast<float>(step)));
}

namespace {
/// The steps of a block of rays, and what each of them scatters.
struct Steps {
    std::vector<AirStepping> of_ray;
    std::vector<float> weights; ///< Per ray and step; sums over the lights.
    std::vector<float> shares;  ///< Lit, of the current ray and light.
    LitRows lit;
    std::vector<ScatterPiece> pieces;
};

/// What a sun scatters to the camera per metre of a step, if it were lit; mean over the channels.
void add_directional(const ViewRay& ray, std::span<const MediumSegment> segments, const DirectionalScatter& light,
                     float strata_weight, const AirStepping& stepping, Steps& steps, std::span<float> weights) {
    steps.pieces.clear();
    light.append_pieces(ray, segments, steps.pieces);
    auto piece = steps.pieces.begin();
    for (std::size_t step = 0; step < weights.size(); ++step) {
        if (steps.shares[step] == 0.0f)
            continue;
        const float at_m = stepping.at_m()[step];
        while (piece + 1 != steps.pieces.end() && at_m > piece->far_m)
            ++piece;
        const Rgb depth = piece->depth_at_near + (at_m - piece->near_m) * piece->depth_per_m;
        weights[step] += strata_weight * steps.shares[step] * average(piece->source_per_m * glm::exp(-depth));
    }
}

/// The same of a lamp. The inverse square is integrated over the step, in the angle in which the lamp sees it; the rest is
/// that of its point, with the step's medium all the way to the lamp.
void add_local(const Media& media, const ViewRay& ray, std::span<const MediumSegment> segments,
               const LightSample& light, bool attenuates_light, float strata_weight, const AirStepping& stepping,
               Steps& steps, std::span<float> weights) {
    const vec3 foot_way = light.position - ray.origin;
    const float foot_m = glm::dot(foot_way, ray.direction);
    const float across2 =
        std::max(glm::dot(foot_way, foot_way) - foot_m * foot_m, 1e-12f * glm::dot(foot_way, foot_way));
    const float across_m = std::sqrt(across2 + light.softening_m2);
    for (std::size_t step = 0; step < weights.size(); ++step) {
        if (steps.shares[step] == 0.0f)
            continue;
        const float at_m = stepping.at_m()[step], half_m = 0.5f * stepping.step_m();
        const float begin = at_m - half_m - foot_m, end = at_m + half_m - foot_m;
        const float angle = std::atan2((end - begin) * across_m, across_m * across_m + begin * end);
        const vec3 from_light = ray.origin + at_m * ray.direction - light.position;
        const float distance_m = glm::length(from_light);
        const vec3 direction = from_light / distance_m;
        const MediumSet& set = segments[stepping.segment_of()[step]].set;
        Rgb depth = stepping.depths()[step];
        if (attenuates_light)
            depth += media.sigma_t_per_m(set) * distance_m;
        const Rgb source = intensity_w_per_sr(light, direction) *
                           media.scatter_per_m_sr(set, -glm::dot(direction, ray.direction)) * glm::exp(-depth);
        weights[step] += strata_weight * steps.shares[step] * average(source) * angle / (across_m * stepping.step_m());
    }
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
        steps.of_ray.resize(std::max(steps.of_ray.size(), block.rays.size()));
        steps.weights.assign(block.rays.size() * step_count, is_whole ? 1.0f : 0.0f);
        for (std::size_t ray = 0; ray < block.rays.size(); ++ray)
            steps.of_ray[ray].assign(prepared_.media, block.segments_of(ray), wanted.step_count, offset(),
                                     is_whole ? std::numeric_limits<float>::infinity() : most_depth_of_light);
        if (!is_whole)
            for (const LightBeams& light : prepared_.lights)
                add(light, block, steps);
        for (std::size_t ray = 0; ray < block.rays.size(); ++ray) {
            const auto weights = std::span<const float>(steps.weights).subspan(ray * step_count, step_count);
            if (std::ranges::all_of(weights, [](float weight) { return weight == 0.0f; }))
                continue;
            const AirStepping& stepping = steps.of_ray[ray];
            heterogeneity[block.target[ray]] = air_.mean({.origin = block.rays[ray].origin,
                                                          .direction = block.rays[ray].direction,
                                                          .at_m = stepping.at_m(),
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
            if (beam.directional)
                add_directional(block.rays[ray], block.segments_of(ray), *beam.directional, strata_weight, stepping,
                                steps, weights);
            else
                add_local(prepared_.media, block.rays[ray], block.segments_of(ray), beam.sample,
                          prepared_.attenuates_light, strata_weight, stepping, steps, weights);
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
    std::vector<std::uint32_t> order(rays.size());
    std::iota(order.begin(), order.end(), 0u);
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
