// SPDX-License-Identifier: GPL-3.0-or-later
// Scattering by fibres too thin to show their width: what each of a fibre's lobes sends back, 1/sr, and directions drawn as
// often. Angles are measured on the fibre: theta out of the plane across it, phi around it from the way to the viewer.
// Based on: Marschner et al., Light Scattering from Human Hair Fibers, SIGGRAPH 2003; d'Eon et al., An Energy-Conserving
//           Hair Reflectance Model, EGSR 2011 (eq. 7, and section 5 for drawing theta); Chiang et al., A Practical and
//           Controllable Hair and Fur Model for Production Path Tracing, EG 2016 (the logistic for phi); up to here for
//           Principled Hair. The Hair BSDF: blender v4.5.0, intern/cycles/kernel/closure/bsdf_hair.h, for which
//           distributions it takes: Cauchy's along; a cosine, or Cauchy's again, around.
// Differs:  eq. 7 is written with exp(-x) I0(x), so that one formula serves every variance, and with the difference of both
//           directions, of which floats keep all digits where lobes are narrow. Cycles' I0 is a series cut short: it is up
//           to 1.5 % too dark where x is near 12. Up to Blender 3.x scales tilt the light's angle, which keeps not all light:
//           what is drawn is then not quite as often as what is sent back, and weighed by it.
// Bound:    15 ns a direction and 25 a lobe; two numbers draw a direction, of which the second is used twice.
#pragma once
#include "core/math.hpp"
#include "shading/lobes/lobe.hpp"

namespace tyndall::fibre {
/// Unit vectors: along a fibre, and across it, the second of them as near to the viewer as can be.
struct Frame {
    vec3 along, across, towards_viewer;
    Frame(const vec3& along, const vec3& outgoing);
    [[nodiscard]] vec3 direction(float sine_theta, float cosine_theta, float phi) const;
};
struct Angles {
    float sine_theta, cosine_theta, phi; ///< phi of the viewer is 0; positive towards `across`.
};
[[nodiscard]] Angles angles_of(const Frame& frame, const vec3& direction);

/// exp(-x) I0(x) for x >= 0; Abramowitz and Stegun, 9.8.1 and 9.8.2, to 2e-7.
[[nodiscard]] float scaled_bessel_i0(float x);
/// d'Eon's M of two directions' theta, which the fibre mirrors if they add up to 0: over the first, times its cosine, it
/// integrates to 1.
[[nodiscard]] float along_fibre(float sine, float cosine, float viewer_sine, float viewer_cosine, float variance);
/// The logistic of this scale on [-pi, pi], which integrates to 1.
[[nodiscard]] float trimmed_logistic(float phi, float scale);
/// Of [0, 1), as often.
[[nodiscard]] float sample_trimmed_logistic(float u, float scale);

/// What lobes along one fibre ask of two unit directions, once for all of them.
struct Meeting {
    Frame frame;
    Angles light;
    float viewer_sine, viewer_cosine; ///< Of its theta.
    Meeting(const vec3& along, const vec3& outgoing, const vec3& incoming);
};
/// What M and the logistic are divided by, for Lobe::b: (along, around, 0).
[[nodiscard]] Rgb inverse_integrals(float variance_along, float scale_around);

/// Of a lobe of these kinds, 1/sr. How bright it is, with the light's cosine on no surface but on the fibre, which is that of
/// the model; and how often sample() draws it.
[[nodiscard]] float scattered(const Lobe& lobe, const Meeting& meeting);
[[nodiscard]] float pdf_per_sr(const Lobe& lobe, const Meeting& meeting);
[[nodiscard]] vec3 sample(const Lobe& lobe, const vec3& outgoing, vec2 u);
/// No direction is denser.
[[nodiscard]] float most_pdf_per_sr(const Lobe& lobe, const vec3& outgoing);
} // namespace tyndall::fibre
