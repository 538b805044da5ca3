// SPDX-License-Identifier: GPL-3.0-or-later
// A light at a point in homogeneous media: single scattering over lit intervals by error-controlled quadrature.
// Based on: Kulla and Fajardo, Importance Sampling Techniques for Path Tracing in Participating Media, EGSR 2012: in the
//           angle under which the light sees the ray, 1 / r^2 is a constant. Integrated by nested Gauss-Kronrod rules.
// Differs:  the airlight of a point light (Sun et al., SIGGRAPH 2005) has a table of special functions that is singular
//           where the ray points at the light; here the angle of an interval comes from one stable arctangent, and the
//           integrand is smooth between the splits: media, their shadow edges as the light sees them, cones, horizons.
// Bound:    7 or 15 points per smooth stretch, one exponential each in a grey medium, three in a coloured one. Relative
//           error 1e-5 of the result (tests), apart from a light that is moved off the ray by 1e-6 of its distance.
#pragma once
#include "light_shafts/light_shafts.hpp"
#include "light_shafts/local_scatter_kernel.hpp"
#include "scene/media.hpp"
#include "scene/plane_cut.hpp"
#include <span>
#include <vector>

namespace tyndall::light_shafts {
/// What one local light scatters along view rays. Safe from any thread, each with its own Prepared.
class LocalScatter {
public:
    /// `media` and what `light` points to must outlive this.
    LocalScatter(const Media& media, const LightSample& light, bool attenuates_light);

    /// The light is black, or no medium scatters.
    [[nodiscard]] bool is_black() const { return is_black_; }

    /// A boundary of a medium between the ray and the light: the line a x + b y = c in their plane.
    struct Crossing {
        double near_m, far_m; ///< Where on the ray the light casts it.
        double a, b, c;
        dvec3 signed_sigma_t; ///< Positive where the way to the light leaves the medium.
    };
    /// A stretch of the ray on which the integrand is smooth.
    struct Stretch {
        double near_m, far_m;
        MediumSet set;
        dvec3 sigma_t, camera_depth_at_near;
        std::uint32_t first_crossing, crossing_count; ///< Into Prepared::crossing_of_stretch.
    };
    /// One ray, ready for any number of lit intervals.
    struct Prepared {
        double light_x, light_y, softened_y;
        vec3 origin, direction;
        std::vector<Stretch> stretches;
        std::vector<Crossing> crossings;
        std::vector<std::uint32_t> crossing_of_stretch;
        std::vector<double> splits;
    };
    /// `segments`: Media::segments of the ray.
    void prepare(const ViewRay& ray, std::span<const MediumSegment> segments, Prepared& prepared) const;
    /// Radiance that [near_m, far_m] of the ray, all of it lit, sends to the camera, W/(m^2 sr).
    [[nodiscard]] Rgb scattered(const Prepared& prepared, float near_m, float far_m) const;

private:
    /// The integrand on a stretch; it refers to `crossings` and `lobes`, which it fills.
    [[nodiscard]] AngularSource source(const Prepared& prepared, const Stretch& stretch,
                                       std::vector<AngularSource::Crossing>& crossings,
                                       std::vector<AngularSource::Lobe>& lobes) const;
    void append_crossings(const ViewRay& ray, const LocalPlane& plane, Prepared& prepared) const;
    void append_splits_of_shape(const ViewRay& ray, std::vector<double>& splits) const;

    const Media& media_;
    LightSample light_;
    dvec3 sigma_t_at_light_{0.0}; ///< Of the media that hold the light.
    bool attenuates_light_, is_black_;
};
} // namespace tyndall::light_shafts
