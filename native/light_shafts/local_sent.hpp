// SPDX-License-Identifier: GPL-3.0-or-later
// What a view ray sends of a local light by its pieces so far, at least: beside that, pieces behind much fog are nothing.
// Based on: the angle under which the light sees a piece (local_scatter.hpp) over the distance between light and ray, times
//           what the media scatter and what is left of it: bounds of each from both sides.
// Differs:  of a piece only its first part counts, that loses at most one optical depth.
// Bound:    a logarithm per ray and one per piece.
#pragma once
#include "light_shafts/local_rays.hpp"
#include "light_shafts/local_scatter_kernel.hpp"
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace tyndall::light_shafts {
class LocalSent {
public:
    /// `light_m` and `softened_m`: LocalSupport's LightY and SoftenedY; `light_side_per_m`: of the optical depth between
    /// light and any point of the ray, at most.
    void begin_ray(const LocalRays& rays, double light_m, double softened_m, double light_side_per_m) {
        light_m_ = light_m, softened_m_ = softened_m, light_side_per_m_ = light_side_per_m;
        log_most_scatter_ = rays.log_most_scatter() + log_most_unknown;
        log_most_ = log_most_scatter_ + std::log(std::numbers::pi / (LocalPieces::nothing * softened_m));
        forget();
    }
    void forget() { log_sent_ = -std::numeric_limits<double>::infinity(); }
    /// A piece that begins at x0 from the light's foot, behind this depth, and that so much of the light reaches. Near to
    /// far.
    void add(const SetOfMedia& set, double x0, double length_m, const dvec3& depth, const Rgb& reaches) {
        const double part_m = std::min(length_m, 1.0 / std::max(largest(set.sigma_t) + light_side_per_m_, 1e-30));
        const double farthest_m = std::max(std::abs(x0), std::abs(x0 + part_m));
        const double least = set.least_scatter * std::min({reaches.x, reaches.y, reaches.z}) * part_m /
                             (farthest_m * farthest_m + softened_m_ * softened_m_);
        const double light_side = light_side_per_m_ * std::sqrt(x0 * x0 + light_m_ * light_m_);
        log_sent_ = std::max(log_sent_, std::log(least) - largest(depth) - light_side - 1.0);
    }
    /// What lies behind that depth is nothing.
    [[nodiscard]] bool is_lost(const dvec3& depth) const {
        return log_most_ - std::min({depth.x, depth.y, depth.z}) < log_sent_;
    }
    /// LocalPieces::log_share.
    [[nodiscard]] double log_share() const { return log_most_scatter_ - log_sent_; }

private:
    static double largest(const dvec3& value) { return std::max({value.x, value.y, value.z}); }
    /// How much less than it could the light may shine along what is nearer, by its cone or its face: 100 times.
    static constexpr double log_most_unknown = 4.6;

    double light_m_ = 0.0, softened_m_ = 0.0, light_side_per_m_ = 0.0;
    double log_most_scatter_ = 0.0; ///< Per angle and metre; for a strength of 1, as all of these.
    double log_most_ = 0.0;         ///< Of the whole ray but for its losses, over what counts as nothing.
    double log_sent_ = 0.0;
};
} // namespace tyndall::light_shafts
