// SPDX-License-Identifier: GPL-3.0-or-later
// How a ray's light is weighted when the texture of the air is averaged along it: steps, and what each of them scatters.
// Based on: Kol, dissertation, TU Delft 2018, section 5.4.3.
// Differs:  the paper averages over the whole ray, lit or not, with a visibility lookup per step; here shadows do not count
//           (unless that is asked for), a step knows exactly how much of it is lit, and brighter parts count for more.
//           Steps have no jitter: nothing but the noise is sampled, which is smooth at their distance, see AirTexture; the
//           samples of a pixel shift them instead.
// Data flow: ray -> steps over its length in media -> per light: lit share of each step -> times what it
//           scatters, summed over the lights -> mean of the air's texture.
// Bound:    per ray and light one question for its lit shares; per step one exponential and, where it is lit, one look-up
//           of the texture.
#pragma once
#include "light_shafts/prepared_lights.hpp"
#include "light_shafts/turns.hpp"
#include "volume/air_texture.hpp"

namespace tyndall::light_shafts {
/// Light beyond this depth, a thousandth, counts for the texture no more.
inline constexpr float most_depth_of_light = 7.0f;
/// Strata of a light that the texture of a pixel is asked for: they change its weights only, and those in penumbras.
inline constexpr std::size_t strata_of_texture = 4;
/// Calls visit(beam, weight) for those of a light that a pass asks for.
template <class Visit>
void for_texture_beams(const LightBeams& light, const Turn& turn, const Visit& visit) {
    const Deal mine = deal(light.stratum_count(), turn);
    const std::size_t most = std::max<std::size_t>(1, strata_of_texture / turn.count);
    const std::size_t stride = (mine.last - mine.first + most - 1) / most;
    for (std::size_t index = mine.first; index < mine.last; index += stride) {
        const std::size_t first = spread(index, light.stratum_count()) * light.parts;
        for (const Beam& beam : std::span(light.beams).subspan(first, light.parts))
            visit(beam, mine.weight * static_cast<float>(stride));
    }
}
/// Where in its steps a pass looks: those of a pixel's passes fill the steps evenly.
[[nodiscard]] inline float offset_in_step(const Turn& turn) {
    return (static_cast<float>(spread(turn.index, turn.count)) + 0.5f) / static_cast<float>(turn.count);
}

/// The rays that have dark_air. Throws Cancelled.
[[nodiscard]] std::vector<std::uint32_t> find_dark(std::span<const float> heterogeneity, const Progress& progress);

/// Steps of one length over the parts of a ray that lie in media; what lies between two media is no part of any step.
class AirStepping {
public:
    /// `segments`, at least one, and `media` must outlive this. `offset` in (0, 1): where in a step its point lies.
    /// `most_depth`: optical depth, from the camera, at which the steps end.
    AirStepping(const Media& media, std::span<const MediumSegment> segments, std::uint32_t step_count, float offset,
                float most_depth);

    [[nodiscard]] float step_m() const { return step_m_; }
    /// Distances of the steps' points along the ray.
    void find_points(std::span<float> at_m) const;
    /// Adds the share of each step that lies within [near_m, far_m], times `weight`.
    void add_share(float near_m, float far_m, float weight, std::span<float> shares) const;
    /// Calls visit(step, segment, metres into it, optical depth from the camera) for each step's point, near to far.
    template <class Visit>
    void for_each_step(const Visit& visit) const;

private:
    /// Length in media before a point of the ray, in steps.
    [[nodiscard]] float steps_before(float distance_m) const;

    const Media* media_;
    std::span<const MediumSegment> segments_;
    std::uint32_t step_count_;
    float offset_, step_m_ = 0.0f;
};

template <class Visit>
void AirStepping::for_each_step(const Visit& visit) const {
    std::size_t segment = 0;
    Rgb depth_before(0.0f), sigma_t = media_->sigma_t_per_m(segments_.front().set);
    float length_before_m = 0.0f;
    for (std::uint32_t step = 0; step < step_count_; ++step) {
        const float before_m = (static_cast<float>(step) + offset_) * step_m_;
        float length_m = segments_[segment].far_m - segments_[segment].near_m;
        while (segment + 1 < segments_.size() && before_m > length_before_m + length_m) {
            depth_before += sigma_t * length_m;
            length_before_m += length_m;
            ++segment;
            sigma_t = media_->sigma_t_per_m(segments_[segment].set);
            length_m = segments_[segment].far_m - segments_[segment].near_m;
        }
        visit(step, segments_[segment], before_m - length_before_m,
              depth_before + sigma_t * (before_m - length_before_m));
    }
}
} // namespace tyndall::light_shafts
