// SPDX-License-Identifier: GPL-3.0-or-later
// Where panoramic cameras look, by the place in their window, and where they show a direction.
// Based on: blender/cycles v4.5.0, src/kernel/camera/projection.h: the kinds, and where each of them ends.
// Differs:  windows are in each kind's own unit, so that a kind without a lens's numbers needs none. A mirror ball is an
//           equisolid fisheye of all directions: both keep areas. The radius at which a lens polynomial shows an angle is
//           the one that ray() has there, on whichever side of the middle, also where Newton's steps go astray.
#pragma once
#include "core/math.hpp"
#include <array>
#include <cstdint>
#include <limits>
#include <optional>

namespace tyndall {
/// What the two coordinates of the window mean: (0, 0) is straight ahead, x goes right and y up.
enum class PanoramaKind : std::uint8_t {
    Equirectangular = 0,        ///< Longitude and latitude, radians.
    FisheyeEquidistant = 1,     ///< Their length is the angle from ahead, radians.
    FisheyeEquisolid = 2,       ///< Their length is the sine of half the angle: lengths on a sensor by 2 focal lengths.
    FisheyePolynomial = 3,      ///< Lengths on the sensor, in the unit of the polynomial, millimetres in Blender.
    MirrorBall = 4,             ///< Radii of the ball.
    EquiangularCubemapFace = 5, ///< Angles to the right and up, each seen along the other axis, radians.
    CentralCylindrical = 6,     ///< Longitude, radians; height on a cylinder of radius 1.
};

struct Panorama {
    PanoramaKind kind = PanoramaKind::Equirectangular;
    /// Of fisheyes and mirror balls: the longest way from (0, 0) that is shown; of a polynomial the largest angle, radians.
    float rim = std::numeric_limits<float>::infinity();
    std::array<float, 5> angle_by_radius{}; ///< Polynomial: radians, of the powers 0 to 4 of the radius.
    bool operator==(const Panorama&) const = default;

    /// In the camera's space (-Z is ahead, Y up), of any length above 0; nothing: the window shows nothing there.
    [[nodiscard]] std::optional<vec3> direction(const vec2& at) const;
    /// Where that shows a direction of any length, beyond the rim, too; of places that repeat, the one that is nearest to the
    /// middle of the window from `low` to `high`. Nothing: no place, or a whole circle of them.
    [[nodiscard]] std::optional<vec2> place(const vec3& towards, const vec2& low, const vec2& high) const;
    /// Of a place without a direction: the one just beyond the rim on the way to the middle.
    [[nodiscard]] vec2 beyond_rim(const vec2& at) const;
    /// How far a unit direction turns per step of the window to the right, and up: radians per unit.
    [[nodiscard]] vec2 turns(const vec3& towards) const;

private:
    [[nodiscard]] float angle_at(float radius) const;
    [[nodiscard]] float angle_slope_at(float radius) const;
    /// By Newton's steps, from where a lens without distortion has it; it may not lie there.
    [[nodiscard]] float radius_guess(float angle_rad) const;
    /// Of a polynomial, below 0 on the other side of the middle; nothing up to `reach`.
    [[nodiscard]] std::optional<float> radius_of(float angle_rad, float reach) const;
};
} // namespace tyndall
