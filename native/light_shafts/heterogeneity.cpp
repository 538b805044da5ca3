// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/heterogeneity.hpp"
#include "core/huge_pages.hpp"
#include "core/parallel.hpp"
#include "light_shafts/heterogeneity_kernel.hpp"
#include "light_shafts/picture_air.hpp"
#include "light_shafts/turns.hpp"
#include "scene/softened_patch.hpp"
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
    add_lit_share(steps_before(near_m), steps_before(far_m), weight, shares);
}

namespace {
/// The steps of a block of rays, and what each of them scatters.
struct Steps {
    std::vector<AirStepping> of_ray;
    std::vector<float> weights; ///< Per ray and step; sums over the lights.
    std::vector<float> shares;  ///< Of the current light that are lit: of the current ray, or of all `plain` ones.
    std::vector<float> at_m;    ///< Of the current ray.
    LitRows lit;
    std::vector<ScatterPiece> pieces;
    /// Rays whose steps lie side by side, as almost all do, and the others, which meet several media in turn.
    struct Some {
        std::vector<std::uint32_t> index; ///< In the block.
        std::vector<ViewRay> rays;
        std::vector<float> begin_m, step_m;
        void clear() { index.clear(), rays.clear(), begin_m.clear(), step_m.clear(); }
    } plain, broken;
};

/// What a sun scatters to the camera per metre of a step, if it were lit; mean over the channels.
void add_directional(const ViewRay& ray, std::span<const MediumSegment> segments, const DirectionalScatter& light,
                     float strata_weight, Steps& steps, std::span<const float> shares, std::span<float> weights) {
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
                              .shares = shares.data() + begin,
                              .weights = weights.data() + begin,
                              .count = count});
        first = end;
    }
}

/// The same of a lamp. The inverse square is integrated over the step, in the angle in which the lamp sees it; the rest is
/// that of its point, with the step's medium all the way to the lamp.
void add_local(const Media& media, const ViewRay& ray, const LightSample& light, float strata_weight,
               const AirStepping& stepping, std::span<const float> shares, std::span<float> weights) {
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
        const vec3 at = ray.origin + at_m * ray.direction;
        const LocalView view = view_local(light, at);
        if (light.is_dimmed_by_media)
            depth += media.sigma_t_per_m(segment.set) * view.distance_m;
        const Rgb source = view.irradiance * (glm::dot(at - light.position, at - light.position) + light.softening_m2) *
                           media.scatter_per_m_sr(segment.set, -glm::dot(view.from_light, ray.direction)) *
                           glm::exp(-depth);
        weights[step] += strata_weight * shares[step] * average(source) * angle / (across_m * stepping.step_m());
    });
}

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
        steps.plain.clear(), steps.broken.clear();
        for (std::uint32_t ray = 0; ray < block.rays.size(); ++ray) {
            const std::span<const MediumSegment> segments = block.segments_of(ray);
            const AirStepping& stepping =
                steps.of_ray.emplace_back(prepared_.media, segments, wanted.step_count, offset_in_step(turn_),
                                          is_whole ? std::numeric_limits<float>::infinity() : most_depth_of_light);
            Steps::Some& some = segments.size() == 1 ? steps.plain : steps.broken;
            some.index.push_back(ray);
            some.rays.push_back(block.rays[ray]);
            some.begin_m.push_back(segments.front().near_m);
            some.step_m.push_back(stepping.step_m());
        }
        if (!is_whole)
            for (const LightBeams& light : prepared_.lights)
                for_texture_beams(light, turn_,
                                  [&](const Beam& beam, float weight) { add(beam, weight, block, steps); });
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
    void add(const Beam& beam, float strata_weight, Block& block, Steps& steps) const {
        if (beam.local) {
            if (block.local.is_empty())
                block.local.assign(prepared_.media, block.rays, block.first_segment, block.segments);
            steps.lit.clear();
            beam.local->lit_intervals(block.local, beam.visibility.get(), steps.lit);
            for (std::uint32_t ray = 0; ray < block.rays.size(); ++ray)
                if (find_shares(ray, ray, steps))
                    add_local(prepared_.media, block.rays[ray], beam.sample, strata_weight, steps.of_ray[ray],
                              steps.shares, weights_of(ray, steps));
            return;
        }
        const std::size_t step_count = air_.heterogeneity().step_count;
        if (const Steps::Some& plain = steps.plain; !plain.index.empty()) {
            steps.shares.resize(plain.index.size() * step_count);
            beam.visibility->find_lit_shares(
                plain.rays, {plain.begin_m, plain.step_m, static_cast<std::uint32_t>(step_count)}, steps.shares);
            for (std::size_t at = 0; at < plain.index.size(); ++at)
                add_sun(plain.index[at], beam, strata_weight, block, steps,
                        std::span<const float>(steps.shares).subspan(at * step_count, step_count));
        }
        if (const Steps::Some& broken = steps.broken; !broken.index.empty()) {
            steps.lit.clear();
            beam.visibility->lit_intervals(broken.rays, steps.lit);
            for (std::size_t at = 0; at < broken.index.size(); ++at)
                if (find_shares(at, broken.index[at], steps))
                    add_sun(broken.index[at], beam, strata_weight, block, steps, steps.shares);
        }
    }
    [[nodiscard]] std::span<float> weights_of(std::size_t ray, Steps& steps) const {
        const std::size_t step_count = air_.heterogeneity().step_count;
        return std::span(steps.weights).subspan(ray * step_count, step_count);
    }
    /// Of a ray of the block from the lit intervals of a row; false where it has none.
    bool find_shares(std::size_t row, std::size_t ray, Steps& steps) const {
        const std::span<const LitInterval> lit = steps.lit.of_ray(row);
        if (lit.empty())
            return false;
        steps.shares.assign(air_.heterogeneity().step_count, 0.0f);
        for (const LitInterval& interval : lit)
            steps.of_ray[ray].add_share(interval.near_m, interval.far_m, average(interval.transmittance), steps.shares);
        return true;
    }
    void add_sun(std::size_t ray, const Beam& beam, float strata_weight, const Block& block, Steps& steps,
                 std::span<const float> shares) const {
        if (std::ranges::all_of(shares, [](float share) { return share == 0.0f; }))
            return;
        steps.of_ray[ray].find_points(steps.at_m);
        add_directional(block.rays[ray], block.segments_of(ray), *beam.directional, strata_weight, steps, shares,
                        weights_of(ray, steps));
    }

    const PreparedLights& prepared_;
    const AirTexture& air_;
    Turn turn_;
};
} // namespace

std::vector<float> Shafts::find_heterogeneity(std::span<const ViewRay> rays, const AirTexture& air,
                                              const Progress& progress, Turn turn) const {
    std::vector<float> heterogeneity(rays.size(), dark_air);
    find_heterogeneity(rays, air, heterogeneity, progress, turn);
    return heterogeneity;
}

std::vector<std::uint32_t> find_dark(std::span<const float> heterogeneity, const Progress& progress) {
    constexpr std::size_t rays_per_block = 1 << 15;
    std::vector<std::size_t> first((heterogeneity.size() + rays_per_block - 1) / rays_per_block + 1, 0);
    const auto of_block = [&](std::size_t begin, std::size_t end) { return heterogeneity.subspan(begin, end - begin); };
    parallel_blocks(heterogeneity.size(), rays_per_block, progress, [&](std::size_t begin, std::size_t end) {
        first[begin / rays_per_block + 1] =
            static_cast<std::size_t>(std::ranges::count(of_block(begin, end), dark_air));
    });
    std::partial_sum(first.begin(), first.end(), first.begin());
    auto dark = large_vector<std::uint32_t>(first.back());
    parallel_blocks(heterogeneity.size(), rays_per_block, progress, [&](std::size_t begin, std::size_t end) {
        std::size_t next = first[begin / rays_per_block];
        const std::size_t past = first[begin / rays_per_block + 1];
        constexpr std::size_t rays_at_once = 64;
        for (std::size_t few = begin; few < end && next < past; few += rays_at_once) {
            const std::size_t few_end = std::min(few + rays_at_once, end);
            if (std::ranges::count(of_block(few, few_end), dark_air) == 0) // in vectors
                continue;
            for (std::size_t ray = few; ray < few_end; ++ray)
                if (heterogeneity[ray] == dark_air)
                    dark[next++] = static_cast<std::uint32_t>(ray);
        }
    });
    return dark;
}

std::size_t Shafts::find_heterogeneity(std::span<const ViewRay> rays, const AirTexture& air,
                                       std::span<float> heterogeneity, const Progress& progress, Turn turn,
                                       const PictureAir* picture) const {
    require(heterogeneity.size() == rays.size(), "find_heterogeneity: ", rays.size(), " rays, but room for ",
            heterogeneity.size(), " results");
    std::vector<std::uint32_t> asked = find_dark(heterogeneity, progress);
    if (picture != nullptr)
        asked = picture->find(rays, asked, heterogeneity, progress);
    const auto count_dark = [&] {
        return parallel_sum(heterogeneity.size(), 1 << 15, std::size_t{0}, progress, [&](std::size_t begin, auto end) {
            return static_cast<std::size_t>(std::ranges::count(heterogeneity.subspan(begin, end - begin), dark_air));
        });
    };
    if (asked.empty())
        return count_dark();
    // As scatter() asks, where lights are asked: neighbours in the picture read different rows.
    if (air.heterogeneity().weighting == Heterogeneity::Weighting::LitParts && prepared_->finest != nullptr)
        prepared_->finest->make_coherent(rays, asked, progress);
    const TexturedBlock textured(*prepared_, air, turn);
    constexpr std::size_t rays_per_block = 256;
    parallel_blocks(asked.size(), rays_per_block, progress, [&](std::size_t begin, std::size_t end) {
        thread_local Block block;
        thread_local Steps steps;
        prepared_->gather(rays, std::span(asked).subspan(begin, end - begin), block);
        textured.find(block, steps, heterogeneity);
    });
    return count_dark();
}
} // namespace tyndall::light_shafts
