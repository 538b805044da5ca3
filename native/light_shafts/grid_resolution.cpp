// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/grid_resolution.hpp"
#include "core/parallel.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace tyndall::light_shafts {
namespace {
constexpr std::size_t most_rays = 64, most_beams = 3;
constexpr std::array candidate_steps{16.0f, 8.0f, 4.0f, 2.0f}; // voxels
// voxels. 0: no columns, each point's light walks: in density that ends it within a voxel no columns are near enough, and
// walks are short.
constexpr std::array candidate_spacings{8.0f, 4.0f, 2.0f, 1.0f, 0.5f, 0.25f, 0.0f};
constexpr double most_bytes = 0x1p30; // of columns, but for the farthest apart, which may take more
constexpr float coarsest_error = 0.1f;

StepLimits limits_of(float length_voxels) {
    return {.length_voxels = length_voxels, .depth_gain = std::min(0.5f, 0.05f * length_voxels)};
}

/// Rays of the frame that meet density, and what the strongest lights scatter along them.
class Pilot {
public:
    Pilot(const Media& media, std::span<const ViewRay> rays, std::span<LightBeams> lights, const LightShares& shares,
          const Progress& progress)
        : media_(media), progress_(progress) {
        for (LightBeams& light : lights) {
            const auto strongest =
                std::ranges::max_element(light.beams, {}, [&](const Beam& beam) { return shares.share(beam.share); });
            const float share =
                std::accumulate(light.beams.begin(), light.beams.end(), 0.0f,
                                [&](float sum, const Beam& beam) { return sum + shares.share(beam.share); });
            beams_.push_back({&*strongest, share});
            beam_count_ += light.beams.size();
            stratum_count_ += light.stratum_count();
        }
        std::ranges::stable_sort(beams_, std::ranges::greater(), &WeightedBeam::share);
        beams_.resize(std::min(beams_.size(), most_beams));
        gather(rays);
    }
    [[nodiscard]] bool is_empty() const { return rays_.empty(); }
    [[nodiscard]] std::size_t beam_count() const { return beam_count_; } ///< Of all lights.

    void dim(const GridLoss& loss) {
        for (const WeightedBeam& weighted : beams_)
            weighted.beam->dim_by_grids(loss);
    }
    /// Of all beams, if they were as the largest of these, after rays have asked them. Beams that share a stratum are
    /// asked for different columns.
    [[nodiscard]] double most_bytes() const {
        double most = 0.0;
        for (const WeightedBeam& weighted : beams_) {
            const ColumnBytes bytes = weighted.beam->column_bytes();
            most = std::max(most, bytes.of_places * static_cast<double>(beam_count_) +
                                      bytes.of_values * static_cast<double>(stratum_count_));
        }
        return most;
    }
    /// Beam by beam, ray by ray.
    [[nodiscard]] std::vector<Rgb> radiance(const StepLimits& limits) const {
        std::vector<Rgb> result(beams_.size() * rays_.size());
        parallel_for(
            rays_.size(), progress_,
            [&](std::size_t ray) {
                const std::uint32_t first = first_segment_[ray], end = first_segment_[ray + 1];
                const std::span<const MediumSegment> segments = std::span(segments_).subspan(first, end - first);
                MediumSteps steps;
                const ViewRay& own = rays_[ray];
                append_steps(media_, {own.origin, own.direction, own.near_m, own.far_m}, segments, limits, steps);
                for (std::size_t beam = 0; beam < beams_.size(); ++beam)
                    result[beam * rays_.size() + ray] = scattered_along(*beams_[beam].beam, own, segments, steps);
            },
            1);
        return result;
    }
    struct Error {
        float rms = 0.0f;  ///< Over the rays, relative, of the sum of the lights by their shares.
        float mean = 0.0f; ///< What all rays and lights have in common of it, and more lights do not average out.
    };
    [[nodiscard]] Error error(const std::vector<Rgb>& found, const std::vector<Rgb>& reference) const {
        double sum = 0.0, shares = 0.0, difference_of_all = 0.0;
        for (std::size_t beam = 0; beam < beams_.size(); ++beam) {
            double difference2 = 0.0, reference2 = 0.0, difference_sum = 0.0, reference_sum = 0.0;
            for (std::size_t at = beam * rays_.size(); at < (beam + 1) * rays_.size(); ++at) {
                const Rgb difference = found[at] - reference[at];
                difference2 += glm::dot(difference, difference);
                reference2 += glm::dot(reference[at], reference[at]);
                difference_sum += average(difference), reference_sum += average(reference[at]);
            }
            const double share = beams_[beam].share;
            if (reference2 > 0.0) {
                sum += share * share * difference2 / reference2;
                difference_of_all += share * difference_sum / reference_sum;
            }
            shares += share;
        }
        if (!(shares > 0.0))
            return {};
        return {static_cast<float>(std::sqrt(sum) / shares), static_cast<float>(std::abs(difference_of_all) / shares)};
    }

private:
    struct WeightedBeam {
        Beam* beam;
        float share;
    };
    void gather(std::span<const ViewRay> rays) {
        std::vector<const ViewRay*> met;
        std::vector<LinePart> parts;
        const std::size_t step = std::max<std::size_t>(1, rays.size() / (16 * most_rays));
        for (std::size_t index = step / 2; index < rays.size(); index += step) {
            parts.clear();
            const ViewRay& ray = rays[index];
            media_.grids().append_dense_parts({ray.origin, ray.direction, ray.near_m, ray.far_m}, parts);
            if (!parts.empty())
                met.push_back(&ray);
        }
        const std::size_t stride = std::max<std::size_t>(1, met.size() / most_rays);
        for (std::size_t index = stride / 2; index < met.size() && rays_.size() < most_rays; index += stride) {
            rays_.push_back(clip_to_media(media_, *met[index], segments_).clipped);
            first_segment_.push_back(static_cast<std::uint32_t>(segments_.size()));
        }
    }
    [[nodiscard]] Rgb scattered_along(const Beam& beam, const ViewRay& ray, std::span<const MediumSegment> segments,
                                      const MediumSteps& steps) const {
        Rgb sum(0.0f);
        if (beam.local) {
            const std::array<std::uint32_t, 2> first{0, static_cast<std::uint32_t>(segments.size())};
            const std::array<std::uint32_t, 1> row{0};
            LocalRays rays;
            rays.assign(media_, {&ray, 1}, first, segments);
            beam.local->scatter_in_grids(rays, steps, row, nullptr, {&sum, 1}, {});
            return sum;
        }
        std::vector<ScatterPiece> pieces;
        beam.directional->append_grid_pieces(ray, segments, steps, 0, pieces);
        for (const ScatterPiece& piece : pieces)
            sum += scattered(piece, piece.near_m, piece.far_m);
        return sum;
    }

    const Media& media_;
    const Progress& progress_;
    std::vector<WeightedBeam> beams_;
    std::size_t beam_count_ = 0, stratum_count_ = 0;
    std::vector<ViewRay> rays_;
    std::vector<std::uint32_t> first_segment_{0};
    std::vector<MediumSegment> segments_;
};
} // namespace

GridResolution choose_grid_resolution(const Media& media, std::span<const ViewRay> rays, std::span<LightBeams> lights,
                                      const LightShares& shares, const Config& config, const Progress& progress) {
    Pilot pilot(media, rays, lights, shares, progress);
    GridResolution result;
    result.loss.spacing_voxels = candidate_spacings[1];
    if (pilot.is_empty()) // only their shadows are seen
        return result;
    // Both errors together are the frame's; those of many light samples average out.
    const float of_steps = config.grid_error_target * std::numbers::sqrt2_v<float> * 0.5f;
    const auto count = static_cast<float>(pilot.beam_count());
    const float of_loss = std::min(of_steps * std::sqrt(count), std::max(of_steps, coarsest_error));
    pilot.dim({.spacing_voxels = 0.0f, .piece_voxels = 1.0f});
    const std::vector<Rgb> reference = pilot.radiance(limits_of(1.0f));
    std::vector<Rgb> by_steps;
    for (const float length_voxels : candidate_steps) {
        result.step_limits = limits_of(length_voxels);
        result.loss.piece_voxels = length_voxels;
        pilot.dim({.spacing_voxels = 0.0f, .piece_voxels = length_voxels});
        by_steps = pilot.radiance(result.step_limits);
        result.step_error = pilot.error(by_steps, reference).rms;
        if (result.step_error <= of_steps)
            break;
    }
    for (const float spacing_voxels : candidate_spacings) {
        GridLoss loss = result.loss;
        loss.spacing_voxels = spacing_voxels;
        pilot.dim(loss);
        const Pilot::Error error = pilot.error(pilot.radiance(result.step_limits), by_steps);
        if (spacing_voxels != candidate_spacings.front() && pilot.most_bytes() > most_bytes) {
            if (result.loss_error > std::max(of_loss, coarsest_error))
                result.loss.spacing_voxels = result.loss_error = 0.0f;
            break;
        }
        result.loss = loss;
        result.loss_error = error.rms;
        if (error.rms <= of_loss && error.mean <= of_steps)
            break;
    }
    return result;
}
} // namespace tyndall::light_shafts
