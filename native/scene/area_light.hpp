// SPDX-License-Identifier: GPL-3.0-or-later
// Area lights: rectangles and ellipses that shine to one side.
// Based on: Urena, Fajardo and King, An Area-Preserving Parametrization for Spherical Rectangles, EGSR 2013; spread: a
//           soft box's grid of slats, as Cycles has it (blender/cycles, src/kernel/light/area.h of v3.4.0 and v4.5.0;
//           measured in Blender 3.4.1, 4.5.15 and 5.0.1).
// Differs:  the paper's four angles between planes are one quarter turn minus arctangents, of which the solid angle is the
//           sum: nothing cancels where they are all nearly right angles. Of a spread, only what shines on the receiver is
//           sampled. An ellipse that is near is its box with the corners dark; from afar, where the difference between its
//           nearest and its farthest part matters little, its own area is sampled.
#pragma once
#include "scene/light.hpp"
#include <algorithm>

namespace tyndall {
/// Intensity of an area light towards an angle t off its axis: gain (cos t - cotangent sin t), of what it would send along
/// its axis without slats. The gain makes up for what they hold back.
struct AreaSpread {
    float gain = 1.0f, cotangent = 0.0f;
    [[nodiscard]] float lobe(float cosine, float sine) const { return std::max(0.0f, cosine - cotangent * sine); }
};
[[nodiscard]] AreaSpread area_spread(const Light& light);
/// An area light whose spread leaves out some of the directions before it.
[[nodiscard]] bool is_narrow_area(const Light& light);
[[nodiscard]] float area_m2(const Light& light);
/// A place on it, uniform.
[[nodiscard]] vec3 area_point(const Light& light, vec2 u);

/// Nearer than this to each other, a light's nearest and farthest parts send about the same: squares of the distances.
inline constexpr float area_far_ratio = 2.0f;
/// Below it, a rectangle's solid angle is not known well enough from four arctangents: its area is sampled.
inline constexpr float least_solid_angle_sr = 0.01f;

/// Of a rectangle in a plane `height` away: its corners are told from the point's foot in that plane.
[[nodiscard]] double rectangle_solid_angle_sr(const dvec2& low, const dvec2& high, double height);

/// A place on it for one receiver.
struct AreaPoint {
    vec3 position;
    /// By what the light's strength is to be multiplied, so that strength, lobe and the inverse square of the distance
    /// are the irradiance per density; the spread's gain is in it. 0: nothing shines from there.
    float share;
};
[[nodiscard]] AreaPoint area_point_towards(const Light& light, vec2 u, const vec3& receiver);
} // namespace tyndall
