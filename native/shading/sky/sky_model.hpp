// SPDX-License-Identifier: GPL-3.0-or-later
// The light of clear skies over a round Earth, by models of the air.
#pragma once
#include "core/math.hpp"
#include "core/progress.hpp"
#include <vector>

namespace tyndall::sky {
enum class Model : std::uint8_t {
    SingleScattering3 = 0, ///< Blender up to 4.5: the rows of its picture lie half a texel higher.
    SingleScattering = 1,
    MultipleScattering = 2, ///< Blender from 5.0 on.
};

/// Densities are multiples of Earth's.
struct Air {
    float altitude_m = 0.0f; ///< Of who looks.
    float molecules = 1.0f, aerosols = 1.0f, ozone = 1.0f;
};

/// Both halves of the sky around the sun: from left to right all the way around, the sun's side in the middle, rows
/// bottom to top. Half of the rows are below the horizon; towards it they lie closer, by the square.
inline constexpr std::uint32_t picture_width = 512, picture_height = 256;
/// CIE XYZ radiance without the sun's disc, picture_width * picture_height. Throws Cancelled.
[[nodiscard]] std::vector<vec3> picture(Model model, const Air& air, float sun_elevation_rad, const Progress& progress);

/// CIE XYZ irradiance of the sun on a plane that faces it, seen through the air at that height.
[[nodiscard]] vec3 sun_irradiance_xyz(Model model, const Air& air, float elevation_rad);

namespace detail {
/// Per nanometre of 21 wavelengths from 380 to 780 nm.
[[nodiscard]] std::vector<vec3> single_scattering_picture(Model model, const Air& air, float sun_elevation_rad,
                                                          const Progress& progress);
[[nodiscard]] vec3 single_scattering_sun(const Air& air, float elevation_rad);
[[nodiscard]] std::vector<vec3> multiple_scattering_picture(const Air& air, float sun_elevation_rad,
                                                            const Progress& progress);
[[nodiscard]] vec3 multiple_scattering_sun(const Air& air, float elevation_rad);
} // namespace detail
} // namespace tyndall::sky
