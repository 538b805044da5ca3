// SPDX-License-Identifier: GPL-3.0-or-later
// Coordinates in which every light and every camera is the same problem. All planes through a view ray and the light
// share a direction or an axis; such a plane is a slice. In a slice the light's own lines are X = const and the view
// rays are Y = const, straight segments stay straight, and Y grows towards the light: a point of a view ray is lit iff
// its Y is not below the largest Y of the occluders on its light line, the slope of that line.
// Based on: Kol, dissertation, TU Delft 2018, section 5.3 (epipolar rectification of a shadow map).
// Differs:  Kol compares depths texel by texel; here the view ray has one number, and a local light and an
//           orthographic camera are other coefficients of the same projective map instead of other kernels:
//             camera at C, sun        X = 1/r             Y = a/r          axis through C towards the sun
//             camera at C, light at L X = (1 - a/D)/r     Y = a/r          axis through C and L, D = |L - C|
//             orthographic, sun       X = r               Y = a - m r      parallel slices; m is every ray's slope
//             orthographic, light     X = a/r             Y = 1/r          axis through L against the view
//           with a along the axis and r from it, in the slice.
#pragma once
#include "light_shafts/visibility.hpp"
#include <optional>

namespace tyndall::light_shafts::slope_rows {
/// at_origin + per_axial * a + per_radial * r.
struct Linear {
    float at_origin = 0.0f, per_axial = 0.0f, per_radial = 0.0f;
    [[nodiscard]] float at(float a, float r) const { return at_origin + per_axial * a + per_radial * r; }
};

/// Where a view ray lies: everything a query needs, in the frame's coordinates.
struct FramedRay {
    float slice_coordinate; ///< Radians around the axis, (-pi, pi], or metres across the parallel slices.
    float slope;            ///< Y, the same all along the ray.
    float axial, radial;    ///< Of the origin.
    float axial_per_m, radial_per_m;
    float near_m, far_m;
};

struct Frame {
    vec3 origin{0.0f}, axis{0, 0, 1}, u{1, 0, 0}, v{0, 1, 0}; ///< Right-handed: u, v, axis.
    bool is_parallel = false;     ///< Slices are v = const; else half-planes around the axis.
    bool is_angular = false;      ///< Light lines are counted by their angle at the light; else by their r.
    bool is_orthographic = false; ///< Of the view.
    float angle_scale = 0.0f;     ///< X = angle_scale * cot(angle).
    Linear x{1, 0, 0}, y{0, 1, 0}, w{0, 0, 1}; ///< X = x / w, Y = y / w.

    [[nodiscard]] FramedRay place(const ViewRay& ray) const;
    /// What counts the light lines: r in metres or the angle in radians; rises along every view ray.
    [[nodiscard]] float line_at(const FramedRay& ray, float distance_m) const;
    [[nodiscard]] float x_of_line(float line) const;
    /// Unit direction away from a local light along the line at `angle_rad`, in the slice: axial and radial part.
    [[nodiscard]] vec2 line_direction(float angle_rad) const {
        return {(is_orthographic ? 1.0f : -1.0f) * std::cos(angle_rad), std::sin(angle_rad)};
    }
    /// Where a local light stands on the axis.
    [[nodiscard]] float light_axial() const { return is_orthographic ? 0.0f : 1.0f / angle_scale; }
};

/// Nothing where the view and the light span no planes: a light in the camera, a sun along an orthographic view.
[[nodiscard]] std::optional<Frame> make_frame(const View& view, const LightSample& light);
} // namespace tyndall::light_shafts::slope_rows
