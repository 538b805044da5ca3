// SPDX-License-Identifier: GPL-3.0-or-later
// A light at a point in homogeneous media: single scattering over lit intervals by error-controlled quadrature.
// Based on: Kulla and Fajardo, Importance Sampling Techniques for Path Tracing in Participating Media, EGSR 2012: in the
//           angle under which the light sees the ray, 1 / r^2 is a constant.
// Differs:  the airlight of a point light (Sun et al., SIGGRAPH 2005) has a table of special functions that is singular
//           where the ray points at the light; here the angle of an interval comes from one stable arctangent, and the
//           integrand is smooth between the splits: media, their shadow edges as the light sees them, cones, horizons.
//           Rays are first clipped to what the light can shine on, and only the rest asks what casts shadows.
// Bound:    per ray that misses a cone some 5 ns; per lit interval 1 to 3 smooth pieces of 6 points, in SIMD lanes.
//           Relative error 1e-5 of the result (tests), apart from a light that is moved off the ray by 1e-6 of its
//           distance.
#pragma once
#include "light_shafts/light_columns.hpp"
#include "light_shafts/local_crossings.hpp"
#include "light_shafts/local_rays.hpp"
#include "light_shafts/local_support.hpp"
#include "light_shafts/visibility.hpp"
#include "scene/medium_steps.hpp"
#include <functional>
#include <optional>

namespace tyndall::light_shafts {
/// A ray as a light at a point sees it: places on it are measured from the light's foot, its point nearest to the light.
struct RayFromFoot {
    std::uint32_t ray;
    double foot_m;     ///< From the ray's origin.
    double light_m;    ///< From the foot to the light.
    double begin, end; ///< Of what the light can shine on, from the foot.
};
/// Appends places, from the foot, where parts of the ray shall end.
using CutRay = std::function<void(const RayFromFoot& ray, std::vector<double>& cuts)>;
/// A lit part of a ray between two cuts, and the radiance that it sends to the camera.
struct LocalPart {
    std::uint32_t ray;
    float begin, end; ///< From the foot.
    Rgb radiance;
};

/// What one local light scatters along view rays. Safe from any thread.
class LocalScatter {
public:
    /// `media` and what `light` points to must outlive this.
    LocalScatter(const Media& media, const LightSample& light);

    /// The light is black, or no medium scatters.
    [[nodiscard]] bool is_black() const { return is_black_; }
    /// Adds to each ray the radiance that it sends to the camera where `visibility` says that it is lit, W/(m^2 sr); no
    /// visibility: all of it. To lit_length_m, unless its span is empty, the length in media of its lit_intervals, weighted
    /// by the mean of their transmittance. To unshadowed, unless its span is empty, what the light would send if nothing
    /// cast a shadow.
    void add_scattered(const LocalRays& rays, const Visibility* visibility, std::span<Rgb> radiance,
                       std::span<Rgb> unshadowed, std::span<float> lit_length_m) const;
    /// The same part by part, ray by ray and near to far: no part lies across a cut. Appends.
    void append_parts(const LocalRays& rays, const Visibility* visibility, const CutRay& cut,
                      std::vector<LocalPart>& parts) const;
    /// Where there are density grids: ray i of `rays` has the steps of ray step_rows[i]. Overwrites radiance, and unshadowed
    /// unless its span is empty, of each ray.
    void scatter_in_grids(const LocalRays& rays, const MediumSteps& steps, std::span<const std::uint32_t> step_rows,
                          const Visibility* visibility, std::span<Rgb> radiance, std::span<Rgb> unshadowed) const;
    /// As DirectionalScatter's.
    void dim_by_grids(const GridLoss& loss);
    [[nodiscard]] ColumnBytes column_bytes() const { return grid_depth_ ? grid_depth_->bytes() : ColumnBytes{}; }
    /// Whether a grid may stand between the light and some point of the ray.
    [[nodiscard]] bool is_dimmed_by_grids(const ViewRay& ray) const;
    /// Appends what is lit of each ray, in media or not: within the light's cone, half of it in the cone's soft edge.
    void lit_intervals(const LocalRays& rays, const Visibility* visibility, LitRows& lit) const;

private:
    class Batch;
    class GridPieces;
    struct Reached; // local_reached.hpp
    void find_reached(const LocalRays& rays, const Visibility* visibility, Reached& reached) const;
    void add_lit_lengths(const LocalRays& rays, const Reached& reached, std::span<float> lit_length_m) const;

    const Media& media_;
    LightSample light_;
    LocalShape shape_;
    LightSideBoundaries boundaries_;
    std::array<float, 3> sigma_t_at_light_{}; ///< Of the media that hold the light.
    bool is_black_;
    std::optional<GridLightDepth> grid_depth_;
    float grid_piece_m_ = 0.0f; ///< Longest outside of grids, where the light passes through one.
};
} // namespace tyndall::light_shafts
