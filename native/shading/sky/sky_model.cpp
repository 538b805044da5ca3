// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/sky/sky_model.hpp"
#include "core/errors.hpp"
#include <cmath>

namespace tyndall::sky {
static void check(const Air& air, float elevation_rad) {
    for (const float number : {air.altitude_m, air.molecules, air.aerosols, air.ozone, elevation_rad})
        require(std::isfinite(number), "a sky has a setting that is not finite");
    require(air.molecules >= 0.0f && air.aerosols >= 0.0f && air.ozone >= 0.0f, "a sky has less than no air");
}

std::vector<vec3> picture(Model model, const Air& air, float sun_elevation_rad, const Progress& progress) {
    check(air, sun_elevation_rad);
    return model == Model::MultipleScattering
               ? detail::multiple_scattering_picture(air, sun_elevation_rad, progress)
               : detail::single_scattering_picture(model, air, sun_elevation_rad, progress);
}

vec3 sun_irradiance_xyz(Model model, const Air& air, float elevation_rad) {
    check(air, elevation_rad);
    return model == Model::MultipleScattering ? detail::multiple_scattering_sun(air, elevation_rad)
                                              : detail::single_scattering_sun(air, elevation_rad);
}
} // namespace tyndall::sky
