// SPDX-License-Identifier: GPL-3.0-or-later
// What lies below a surface that scatters light inside, from what an artist says of it: the colour that a thick piece has
// under even light, and how far light gets.
// Based on: Chiang, Kutz, Burley, Practical and Controllable Subsurface Scattering for Production Path Tracing, SIGGRAPH
//           Talks 2016; Wrenninge, Villemin, Hery, Path Traced Subsurface Scattering using Anisotropic Phase Functions
//           and Non-Exponential Free Flights, Pixar 17-07, 2017 (the fit of its albedo, for phases of Henyey and
//           Greenstein); Jensen, Marschner, Levoy, Hanrahan, A Practical Model for Subsurface Light Transport, SIGGRAPH
//           2001 (a dipole's albedo); Christensen and Burley, Approximate Reflectance Profiles for Efficient Subsurface
//           Scattering, Pixar 15-04, 2015 (the profile).
// Differs:  units, clamps and the twelve halvings by which a dipole's albedo is inverted are Cycles': where a colour is
//           bright, what is left of them shows in the radius.
//           The profile's radius comes from a closed form, for its integral is a cubic in exp(-r / 3d).
#pragma once
#include "core/math.hpp"
#include <algorithm>
#include <cmath>
#include <cstdint>

namespace tyndall {
/// How light gets from where it is seen to where it came in.
enum class SubsurfaceMethod : std::uint8_t {
    None = 0,
    Profile = 1,        ///< Christensen's and Burley's: by its distance alone.
    CosineWalk = 2,     ///< A random walk inside of the object that begins by the cosine: up to Blender 3.x.
    CosineSkinWalk = 3, ///< The same with radii of a dipole.
    RefractedWalk = 4,  ///< One that begins as facets refract it: from 4.0 on.
    SkinWalk = 5,       ///< One that begins either way, with radii of a dipole.
    Count = 6,
};

namespace subsurface {
/// Radii below it are none, m: the surface is diffuse.
inline constexpr float least_radius_m = 1e-8f;
/// Of a scattering, at which a thick piece has this albedo under light by the cosine; below 1. `g`: of the phase, [0, 0.9].
[[nodiscard]] float single_albedo(float albedo, float g);
/// The radius as the method takes it, m: of a profile its scale, of a walk the mean free path, less what goes ahead.
[[nodiscard]] Rgb mean_free_path(SubsurfaceMethod method, const Rgb& radius_m, const Rgb& albedo, float ior);

/// A profile ends at so many times its scale.
inline constexpr float profile_reach = 16.0f;
/// Per metre of radius, of all directions together; `scale_m` above 0.
[[nodiscard]] inline float profile_density_per_m(float scale_m, float radius_m) {
    constexpr float within_reach = 0.9963790093708328f;
    if (radius_m >= profile_reach * scale_m)
        return 0.0f;
    const float third = std::exp(-radius_m / (3.0f * scale_m));
    return third * (1.0f + third * third) / (4.0f * scale_m * within_reach);
}
/// A radius, as often as the density says; u in [0, 1).
[[nodiscard]] inline float sample_profile_radius_m(float scale_m, float u) {
    constexpr float within_reach = 0.9963790093708328f;
    // 1 - F = (y^3 + 3 y) / 4 with y = exp(-r / 3d), and y = 2 sinh(a) makes of y^3 + 3 y 2 sinh(3 a).
    const float third = 2.0f * std::sinh(std::asinh(2.0f * (1.0f - u * within_reach)) / 3.0f);
    return std::max(0.0f, -3.0f * scale_m * std::log(std::min(third, 1.0f)));
}
} // namespace subsurface
} // namespace tyndall
