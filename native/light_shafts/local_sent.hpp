// SPDX-License-Identifier: GPL-3.0-or-later
// What a view ray sends of a local light by its pieces so far, at least: beside that, pieces behind much fog are nothing.
// Based on: the angle under which the light sees a piece (local_scatter.hpp) over the distance between light and ray, times
//           what the media scatter and what is left of it: bounds of each from both sides.
// Differs:  of a piece only its first part counts, that loses at most one optical depth.
// Bound:    a logarithm per ray and one per piece; nothing where a ray is too thin to lose any.
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
    /// light and any point of the ray, at most; `farthest_x_m`: of what is asked of the ray, from the light's foot;
    /// `depth_at_end`: of the whole ray.
    void begin_ray(const LocalRays& rays, double light_m, double softened_m, double light_side_per_m,
                   double farthest_x_m, const dvec3& depth_at_end) {
        forget();
        light_m_ = light_m, softened_m_ = softened_m, light_side_per_m_ = light_side_per_m;
        is_thin_ = largest(depth_at_end) + light_side_depth(farthest_x_m) < thin_depth;
        if (is_thin_)
            return;
        log_most_scatter_ = rays.log_most_scatter() + log_most_unknown;
        log_most_ = log_most_scatter_ + std::log(std::numbers::pi / (LocalPieces::nothing * softened_m));
    }
    void forget() { log_sent_ = -std::numeric_limits<double>::infinity(); }
    /// A piece that begins at x0 from the light's foot, behind this depth, and that so much of the light reaches. Near to
    /// far.
    void add(const SetOfMedia& set, double x0, double length_m, const dvec3& depth, const Rgb& reaches) {
        if (is_thin_)
            return;
        const double part_m = std::min(length_m, 1.0 / std::max(largest(set.sigma_t) + light_side_per_m_, 1e-30));
        const double farthest_m = std::max(std::abs(x0), std::abs(x0 + part_m));
        const double least = set.least_scatter * std::min({reaches.x, reaches.y, reaches.z}) * part_m /
                             (farthest_m * farthest_m + softened_m_ * softened_m_);
        log_sent_ = std::max(log_sent_, std::log(least) - largest(depth) - light_side_depth(x0) - 1.0);
    }
    /// What lies behind that depth is nothing.
    [[nodiscard]] bool is_lost(const dvec3& depth) const {
        return log_most_ - std::min({depth.x, depth.y, depth.z}) < log_sent_;
    }
    /// LocalPieces::log_share.
    [[nodiscard]] double log_share() const { return log_most_scatter_ - log_sent_; }

private:
    [[nodiscard]] double light_side_depth(double x_m) const {
        return light_side_per_m_ * std::sqrt(x_m * x_m + light_m_ * light_m_);
    }
    static double largest(const dvec3& value) { return std::max({value.x, value.y, value.z}); }
    /// How much less than it could the light may shine along what is nearer, by its cone or its face: 100 times.
    static constexpr double log_most_unknown = 4.6;
    static constexpr double thin_depth = 8.0; ///< With the way to the light: e^-8 of what there is is not nothing.

    bool is_thin_ = false; ///< Nothing of the ray is lost.
    double light_m_ = 0.0, softened_m_ = 0.0, light_side_per_m_ = 0.0;
    double log_most_scatter_ = 0.0; ///< Per angle and metre; for a strength of 1, as all of these.
    double log_most_ = 0.0;         ///< Of the whole ray but for its losses, over what counts as nothing.
    double log_sent_ = 0.0;
};
} // namespace tyndall::light_shafts
