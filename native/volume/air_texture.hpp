// SPDX-License-Identifier: GPL-3.0-or-later
// Heterogeneity made ready to be looked up along rays: noise volume, wind and painted box in one place.
// Differs:  steps far apart look up a level of the noise as coarse as they are: what is finer than they can resolve would
//           be noise of the sampling, not of the air. A level between two belongs to one for some steps and to the other
//           for the rest, by a fixed sequence: along a surface levels change step by step, and no line shows.
//           The cube is turned against the scene's axes: walls and rows of trees do not lie along it.
// Bound:    per step with weight one load of 8 bytes, see air_noise_kernel.hpp; in the painted box 8 voxels of each volume
//           that is painted, see painted_kernel.hpp.
#pragma once
#include "core/progress.hpp"
#include "volume/air_noise.hpp"
#include <memory>
#include <span>
#include <utility>

namespace tyndall {
/// Points of one ray, near to far.
struct AirSteps {
    vec3 origin, direction;         ///< Unit direction; metres.
    std::span<const float> at_m;    ///< Distances from the origin.
    std::span<const float> weights; ///< As many.
    float step_m;                   ///< From one point to the next.
    std::uint32_t first = 0;        ///< Of them, among all points of the ray.
};

/// Immutable; safe from any thread.
class AirTexture {
public:
    /// Makes the noise volume unless it is kept. Throws InvalidInput, which names the culprit, and Cancelled.
    AirTexture(const Heterogeneity& heterogeneity, const Progress& progress);
    /// Shortest edge of a painted voxel, in metres of the scene; infinite where nothing is painted.
    [[nodiscard]] float least_voxel_m() const;
    /// The same air with another weighting.
    [[nodiscard]] AirTexture weighted(Heterogeneity::Weighting weighting) const;

    [[nodiscard]] const Heterogeneity& heterogeneity() const { return heterogeneity_; }
    /// What a point scatters relative to homogeneous air, by noise no finer than `least_level`; `sequence` in [0, 1)
    /// says which of two levels, where the level lies between them.
    [[nodiscard]] float at(const vec3& point, float least_level, float sequence) const;
    /// Points of a ray that mean() and find() take: twice step_count, and up to the next multiple of 16.
    [[nodiscard]] std::uint32_t most_points() const { return (2 * heterogeneity_.step_count + 15) / 16 * 16; }
    /// Mean over the points, of which there are no more than most_points(), in proportion to their weights; 1 where all
    /// of these are 0.
    [[nodiscard]] float mean(const AirSteps& steps) const;
    /// Of each point that has a weight; 0 of the others. Points that are asked together or apart have the same bits.
    void find(const AirSteps& steps, std::span<float> values) const;

private:
    /// Of each point of a ray, relative to what holds everywhere.
    struct Paint {
        std::vector<float> amount, level, intensity;
    };
    /// Of the points in the painted box, from first_m to last_m, that have a weight; the others have what holds everywhere.
    void find_paint(const AirSteps& steps, float first_m, float last_m, Paint& paint) const;
    /// Of the noise, of each point that has a weight; returns the finest.
    [[nodiscard]] float find_levels(const AirSteps& steps, const Paint& paint, float least_level,
                                    std::vector<std::uint8_t>& levels) const;
    /// Where the steps are in the painted box, in metres: .first to .second, which is before it where they are not.
    [[nodiscard]] std::pair<float, float> painted_part(const AirSteps& steps) const;
    [[nodiscard]] float mean_of_painted(const AirSteps& steps, float least_level, float first_m, float last_m) const;
    [[nodiscard]] air_noise::NoiseRay noise_ray(const AirSteps& steps, float level) const;
    [[nodiscard]] float noise_at(const vec3& point, float level, float sequence) const;

    Heterogeneity heterogeneity_;
    std::shared_ptr<const AirNoiseVolume> noise_;
    std::vector<float> sequence_; ///< Per step.
    glm::dmat3 cube_from_scene_;  ///< In cubes, before the wind.
    dvec3 offset_;                ///< The wind's, [0, 1).
    float texel_m_;
};
} // namespace tyndall
