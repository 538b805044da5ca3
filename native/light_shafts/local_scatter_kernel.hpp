// SPDX-License-Identifier: GPL-3.0-or-later
// Gauss's 7 and Kronrod's 15 points on an interval of the angle under which a local light sees a view ray, all points at
// once in SIMD lanes (double precision: the angle nears 90 degrees where a ray passes close by the light).
// Based on: QUADPACK (Piessens et al. 1983), qk15. Integrand: local_scatter.hpp.
// Bound:    15 points in 2 vectors of 8 (AVX-512) or 4 of 4 (AVX2); a sine, a cosine, 1 or 3 exponentials each.
#pragma once
#include "core/math.hpp"
#include <span>

namespace tyndall::light_shafts {
/// Scattering towards the camera on one stretch of a ray, in the terms that the kernel evaluates. x is the distance along
/// the ray from the light's foot, t = light_x + x the distance from the ray's origin.
struct AngularSource {
    double softened_y, light_x, light_y;
    double near_m, far_m; ///< Of the stretch.
    dvec3 camera_depth_at_near, sigma_t, sigma_t_at_light;
    bool is_grey; ///< All channels lose light alike.

    /// A boundary between ray and light, met at the share (c - a t) / (a (light_x - t) + b light_y) of the way.
    struct Crossing {
        double a, b, c;
        dvec3 signed_sigma_t;
    };
    std::span<const Crossing> crossings;

    /// sigma_s (1 - g^2) / (4 pi) over (1 + g^2 - 2 g cosine)^1.5 [Henyey and Greenstein 1941].
    struct Lobe {
        dvec3 weight;
        double one_plus_g2, two_g;
    };
    std::span<const Lobe> lobes;

    /// Point on the ray less the light's position: start + t * along.
    dvec3 start, along;
    bool has_normal = false, is_soft = false, has_spot = false;
    dvec3 normal{0.0};         ///< Cosine lobe of a stratum of a sphere.
    dvec3 falloff_offset{0.0}; ///< Of a stratum of a facing disc; see LightSample.
    double softening_m2 = 0.0;
    struct Spot {
        dvec3 start, along;          ///< start and along in the space of the cone's test, axis along +Z.
        double cos_half, per_smooth; ///< 1 / width of the soft edge in cosine; 0: a hard edge.
        bool keeps_cosine;           ///< Up to 3.x the cosine stays a factor.
    } spot{};
};

struct KronrodSums {
    dvec3 kronrod, gauss; ///< Both times the interval's half length.
};
/// Integrals of the source, for a strength of 1, over angles [from_rad, to_rad].
[[nodiscard]] KronrodSums integrate_angles(const AngularSource& source, double from_rad, double to_rad);
} // namespace tyndall::light_shafts
