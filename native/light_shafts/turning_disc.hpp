// SPDX-License-Identifier: GPL-3.0-or-later
// Lamps whose surroundings reach into them: between boards of a shelf, in a housing narrower than their radius.
// Based on: Cycles' point and spot light with soft falloff (blender/cycles, v3.4.0 light.h, v4.5.0 and v5.0.0 point.h and
//           spot.h): a uniform disc through the lamp's centre that turns to face each receiver.
// Differs:  strata have to stand still. The ball of scene/light.cpp looks like that disc from everywhere, but has a depth:
//           what stands between its front and its back hides other strata than those of the disc; between two boards
//           half a radius away it is 22 % too bright. So directions from the centre are cut into cells, each a pyramid of
//           planes, and in each cell stands a disc that faces its middle. Seen from afar, at an angle t from there, it is
//           the facing disc narrowed by cos t behind whatever stands wholly before it: project a point o along the
//           direction w onto the plane across m, and in the plane of w and m it lies at o.u / cos t. What pierces the disc
//           is met at another height, by a factor of 1 / (1 - tan a tan t) for a plane at the angle a to w. Errors of
//           first order cancel over a cell. Discs are widened by the cell's mean of cos t, and cells turned at random for
//           each stratum: no seam is seen.
// Bound:    the error of the mean falls with the square of the cells' width (measured against marching, 4 to a quarter of
//           a turn): +0.7 % of the lamp's light between two boards half a radius away, +0.5 % in a can of 0.8 radii, 0.1 %
//           with one board, 0.02 % in a soup. A lamp has 6 k^2 cells, a spot those of its cone and five more; a view ray
//           passes through few of them, but each is a light sample that is prepared.
#pragma once
#include "light_shafts/light_shafts.hpp"
#include "light_shafts/ray_outline.hpp"

namespace tyndall::light_shafts {
/// Some triangle that casts a shadow comes closer to `centre` than radius_m.
[[nodiscard]] bool has_occluder_within(const Scene& scene, const vec3& centre, float radius_m);

/// A cell of directions and what stands in it.
struct DiscCell {
    DirectionCell directions;
    vec3 facing;              ///< Unit: its middle.
    float widening = 1.0f;    ///< Of the disc, so that over the cell it has the facing disc's mean width.
    float reach_m = INFINITY; ///< Farther from the apex the lamp does not shine into it.
};
/// How many cells stand side by side on a quarter of a turn, for a relative error of the frame; fewer where `strata`
/// times the cells would be too many to prepare. Lamps with shares s of the frame's light err to the same side, by
/// s / k^2, and cost k^2: cheapest are weights of sqrt(s) times the sum of all their roots (Lagrange).
[[nodiscard]] std::uint32_t cells_per_quarter(float error_target, float weight, std::uint32_t strata);
/// Cells that fill the sphere, turned by `turn` in [0, 1)^3; around a spot's axis, and finer in its cone than beside it.
/// Their number does not depend on `turn`.
[[nodiscard]] std::vector<DiscCell> make_disc_cells(const Light& light, std::uint32_t per_quarter, const vec3& turn);
/// The point `u` of the disc in a cell, with the whole lamp's strength; points to the cell.
[[nodiscard]] LightSample sample_disc(const Light& light, std::uint32_t light_index, const DiscCell& cell, vec2 u);

/// The parts of spans that lie in a cell; spans that miss it are left out.
[[nodiscard]] std::vector<RaySpan> clip_to_cell(std::span<const RaySpan> spans, const DirectionCell& cell,
                                                float reach_m);
} // namespace tyndall::light_shafts
