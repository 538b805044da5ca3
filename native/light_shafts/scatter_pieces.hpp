// SPDX-License-Identifier: GPL-3.0-or-later
// A directional light in homogeneous media, in closed form: a view ray falls into pieces on which the source of
// scattered light is constant and the optical depth, camera's and light's side together, is linear.
// Based on: Kol, dissertation, TU Delft 2018, section 5.3, eq. 5.1.
// Differs:  5.1 leaves out the loss between light and scattering point, which is complete for a sun in a boundless
//           medium, but not in a bounded one, and Cycles has it. Between the crossings of the media's boundaries with
//           the plane of ray and light that loss is linear in the optical depth, so that 5.1 keeps a closed form.
//           5.2 (visibility outside the integral) is up to 3.2x off at optical depth 3 and not used. Written with expm1,
//           and from the end with the smaller depth: exact from 1e-9 to 1e3 per metre, for slopes of either sign.
//           Where density grids modulate media, pieces are steps: their source and slope are the exact means of the
//           densities, and the loss between light and point is interpolated between their ends.
// Bound:    a fog box makes at most 3 pieces per ray; 3 exponentials and 3 expm1 per piece and lit interval.
#pragma once
#include "light_shafts/light_columns.hpp"
#include "light_shafts/light_shafts.hpp"
#include "scene/medium_steps.hpp"
#include <optional>
#include <span>
#include <vector>

namespace tyndall::light_shafts {
/// A part of a view ray with a constant source and a linear optical depth, where it is lit.
struct ScatterPiece {
    float near_m, far_m;
    Rgb source_per_m{0.0f};  ///< Radiance that it scatters towards the camera per metre, W/(m^3 sr), before any loss.
    Rgb depth_at_near{0.0f}; ///< Optical depth from the camera (the ray's near_m) to near_m and on to the light.
    Rgb depth_per_m{0.0f};   ///< Its slope along the ray; negative where the way to the light shortens faster.
};

/// (1 - exp(-x)) / x for x >= 0; 1 at 0.
[[nodiscard]] float mean_transmittance(float optical_depth);
/// Radiance that [near_m, far_m] of the piece, all of it lit, sends to the camera, W/(m^2 sr).
[[nodiscard]] Rgb scattered(const ScatterPiece& piece, float near_m, float far_m);

/// What one directional light scatters along view rays through the media of a scene. Safe from any thread.
class DirectionalScatter {
public:
    /// `media` must outlive this.
    DirectionalScatter(const Media& media, const LightSample& light);

    /// Nothing is scattered: the light is black, no medium scatters, or a medium without bounds swallows it all.
    [[nodiscard]] bool is_black() const { return is_black_; }
    /// Appends the pieces of a ray, near to far; they cover all its media `segments` (of Media::segments, made finite).
    void append_pieces(const ViewRay& ray, std::span<const MediumSegment> segments,
                       std::vector<ScatterPiece>& pieces) const;
    /// The same where there are density grids, in the steps of ray `index` of `steps`.
    void append_grid_pieces(const ViewRay& ray, std::span<const MediumSegment> segments, const MediumSteps& steps,
                            std::size_t index, std::vector<ScatterPiece>& pieces) const;
    /// From now on grids dim the light on its way to a point, too. Throws Cancelled.
    void dim_by_grids(const GridLoss& loss);
    /// Whether a grid may stand between the light and some point of the ray.
    [[nodiscard]] bool is_dimmed_by_grids(const ViewRay& ray) const;
    /// Of what dim_by_grids tabulates.
    [[nodiscard]] ColumnBytes column_bytes() const { return grid_depth_ ? grid_depth_->bytes() : ColumnBytes{}; }

private:
    const Media& media_;
    Rgb irradiance_; ///< 0 in channels that the world's medium swallows.
    LightSample light_;
    bool is_black_;
    std::optional<GridLightDepth> grid_depth_;
    float grid_piece_m_ = 0.0f; ///< Longest outside of grids, where the light passes through one.
};
} // namespace tyndall::light_shafts
