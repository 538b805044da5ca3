// SPDX-License-Identifier: GPL-3.0-or-later
// How a ray's light is weighted when the texture of the air is averaged along it: steps, and what each of them scatters.
// Based on: Kol, dissertation, TU Delft 2018, section 5.4.3.
// Differs:  the paper averages over the whole ray, lit or not, with a visibility lookup per step; here shadows do not count
//           (unless that is asked for), a step knows exactly how much of it is lit, and brighter parts count for more.
//           Steps have no jitter: nothing but the noise is sampled, which is smooth at their distance, see AirTexture; the
//           samples of a pixel shift them instead.
// Data flow: ray -> steps over its length in media -> per light: lit intervals -> lit share of each step -> times what it
//           scatters, summed over the lights -> mean of the air's texture.
// Bound:    per ray and light one question for its lit intervals, 2 additions per interval; per step one exponential
//           and, where it is lit, one look-up of the texture.
#pragma once
#include "light_shafts/prepared_lights.hpp"
#include "volume/air_texture.hpp"

namespace tyndall::light_shafts {
/// Steps of one length over the parts of a ray that lie in media; what lies between two media is no part of any step.
class AirStepping {
public:
    /// `offset` in (0, 1): where in a step its point lies. `most_depth`: optical depth, from the camera, at which the
    /// steps end.
    void assign(const Media& media, std::span<const MediumSegment> segments, std::uint32_t step_count, float offset,
                float most_depth);

    [[nodiscard]] float step_m() const { return step_m_; }
    [[nodiscard]] std::span<const float> at_m() const { return at_m_; }
    /// Adds the share of each step that lies within [near_m, far_m], times `weight`.
    void add_share(float near_m, float far_m, float weight, std::span<float> shares) const;
    /// Optical depth from the camera to the point of a step.
    [[nodiscard]] std::span<const Rgb> depths() const { return depths_; }
    /// Into the ray's segments, per step.
    [[nodiscard]] std::span<const std::uint32_t> segment_of() const { return segment_of_; }

private:
    /// Length in media before a point of the ray, in steps.
    [[nodiscard]] float steps_before(float distance_m) const;

    std::span<const MediumSegment> segments_;
    std::vector<float> length_before_m_; ///< In media, per segment.
    float step_m_ = 0.0f;
    std::vector<float> at_m_;
    std::vector<Rgb> depths_;
    std::vector<std::uint32_t> segment_of_;
};
} // namespace tyndall::light_shafts
