// SPDX-License-Identifier: GPL-3.0-or-later
// Single-scattered radiance along view rays: every light in every medium, over the lit intervals of each ray.
// Based on: Kol, dissertation, TU Delft 2018, chapter 5, section 5.3, eq. 5.1 (TVCG 23(7), 2017).
// Differs:  light is attenuated on its way to the scattering point (switchable: the paper leaves it out); visibility is
//           integrated exactly instead of factored out (5.2 is off by up to 3.2x at optical depth 3); rays that leave to
//           the sky are clipped to the medium.
#pragma once
#include "core/progress.hpp"
#include "core/statistics.hpp"
#include "scene/scene.hpp"
#include <span>
#include <vector>

namespace tyndall::light_shafts {
/// A part of a view ray in front of its surface. Rays of one call share the camera's position or its direction.
struct ViewRay {
    vec3 origin;         ///< Scene space, metres.
    vec3 direction;      ///< Unit.
    float near_m, far_m; ///< far may be infinite; clipped to the media.
};
/// What all view rays of a call have in common.
struct View {
    bool is_orthographic = false;
    vec3 position{0.0f};      ///< Perspective: all rays leave from here.
    vec3 direction{0, 0, -1}; ///< Orthographic: all rays go this way.
};

enum class Method : std::uint8_t { Exact = 0, Epipolar = 1, ShadowMap = 2 };

struct Config {
    Method method = Method::Epipolar;
    float error_target = 0.001f;      ///< Relative error per light that EPIPOLAR picks its resolution by, [1e-5, 0.1].
    std::uint32_t resolution = 0;     ///< Rows' and map's texels per side, [16, 16384]; 0: from error_target.
    std::uint32_t light_samples = 16; ///< Strata of a light with a size, [1, 65536]; one without has one.
    std::uint32_t world_samples = 64; ///< Directions of the world's light, [0, 65536]; 0: it does not scatter.
    bool attenuates_light = true;     ///< False: eq. 5.1 as printed, no loss between light and scattering point.
    std::uint32_t seed = 0;
};

struct Result {
    std::vector<Rgb> radiance;             ///< Per ray, W/(m^2 sr): in-scattered, attenuated to the camera.
    std::vector<float> average_visibility; ///< Per ray, [0, 1]: lit share of its length in media, mean over lights.
    Statistics statistics;
};

/// Throws InvalidInput and Cancelled. The result's bits do not depend on the number of threads.
[[nodiscard]] Result run(const Scene& scene, const View& view, std::span<const ViewRay> rays, const Config& config,
                         Progress& progress);
} // namespace tyndall::light_shafts
