// SPDX-License-Identifier: GPL-3.0-or-later
// Based on: Nishita et al. 1993, Display of the Earth Taking into Account Atmospheric Scattering, at 21 wavelengths, with
//           ozone; the air, the sun and the grid of directions of blender/cycles v4.5.0 and v5.0.0, third_party/sky.
// Differs:  the sun is Planck's law at 5778 K and molecules scatter with the inverse fourth power of the wavelength,
//           which is what Cycles' tables hold; light towards the sun is found by the same 8 points of Gauss-Laguerre,
//           but a direction's 32 steps share them between wavelengths and densities.
// Bound:    32 steps along a ray.
#include "core/parallel.hpp"
#include "shading/sky/sky_model.hpp"
#include <algorithm>
#include <array>
#include <cmath>

namespace tyndall::sky::detail {
namespace {
constexpr float earth_radius_m = 6360e3f, air_radius_m = 6420e3f;
constexpr float molecule_height_m = 8e3f, aerosol_height_m = 1.2e3f; ///< By which they thin out to 1/e.
constexpr float aerosol_scattering_per_m = 2e-5f;
constexpr float aerosol_extinction_per_scattering = 1.11f;
constexpr float mie_asymmetry = 0.76f; ///< Of Cornette and Shanks' phase function.
constexpr int view_step_count = 32;
constexpr std::size_t wavelength_count = 21;
constexpr float first_nm = 380.0f, step_nm = 20.0f;

using Spectrum = std::array<float, wavelength_count>;

/// Bouguer absorption by ozone where there is most of it, per 1e-9 m.
constexpr Spectrum ozone_by_wavelength = {
    0.00325126849861f, 0.00585395365047f, 0.01977191155085f, 0.07309568762914f, 0.20084561514287f, 0.40383958096161f,
    0.63551335912363f, 0.96707041180970f, 1.54797400424410f, 2.09038647223331f, 2.46128056164565f, 2.73551299461512f,
    2.15125862863128f, 1.59051840791988f, 1.12356197979857f, 0.73527551487574f, 0.46450130357806f, 0.33096079921048f,
    0.22512612292678f, 0.14879129266490f, 0.16828623364192f};
/// The CIE's standard observer of 1931.
constexpr std::array<vec3, wavelength_count> observer = {
    {{0.001368f, 0.000039f, 0.006450f}, {0.014310f, 0.000396f, 0.067850f}, {0.134380f, 0.004000f, 0.645600f},
     {0.348280f, 0.023000f, 1.747060f}, {0.290800f, 0.060000f, 1.669200f}, {0.095640f, 0.139020f, 0.812950f},
     {0.004900f, 0.323000f, 0.272000f}, {0.063270f, 0.710000f, 0.078250f}, {0.290400f, 0.954000f, 0.020300f},
     {0.594500f, 0.995000f, 0.003900f}, {0.916300f, 0.870000f, 0.001650f}, {1.062200f, 0.631000f, 0.000800f},
     {0.854450f, 0.381000f, 0.000190f}, {0.447900f, 0.175000f, 0.000020f}, {0.164900f, 0.061000f, 0.0f},
     {0.046770f, 0.017000f, 0.0f},      {0.011359f, 0.004102f, 0.0f},      {0.002899f, 0.001047f, 0.0f},
     {0.000690f, 0.000249f, 0.0f},      {0.000166f, 0.000060f, 0.0f},      {0.000042f, 0.000015f, 0.0f}}};

struct Sunlight {
    Spectrum irradiance_per_nm{}, molecule_scattering_per_m{}, ozone_absorption_per_m{};
    Sunlight() {
        constexpr double planck = 6.62607015e-34, light_speed = 299792458.0, boltzmann = 1.380649e-23;
        constexpr double sun_kelvin = 5778.0, solid_angle_sr = 6.790164e-5, rayleigh_m3 = 1.1311488e-30;
        for (std::size_t index = 0; index < wavelength_count; ++index) {
            const double wavelength_m = (static_cast<double>(first_nm) + step_nm * static_cast<double>(index)) * 1e-9;
            const double fourth = std::pow(wavelength_m, 4.0);
            const double radiance =
                2.0 * planck * light_speed * light_speed /
                (fourth * wavelength_m * std::expm1(planck * light_speed / (wavelength_m * boltzmann * sun_kelvin)));
            irradiance_per_nm[index] = static_cast<float>(radiance * 1e-9 * solid_angle_sr);
            molecule_scattering_per_m[index] = static_cast<float>(rayleigh_m3 / fourth);
            ozone_absorption_per_m[index] = 1e-6f * ozone_by_wavelength[index];
        }
    }
};
const Sunlight& sunlight() {
    static const Sunlight all;
    return all;
}

vec3 to_xyz(const Spectrum& per_nm) {
    vec3 sum(0.0f);
    for (std::size_t index = 0; index < wavelength_count; ++index)
        sum += per_nm[index] * observer[index];
    return step_nm * sum;
}

/// Of molecules, aerosols and ozone, as shares of what they are at most.
vec3 densities(float height_m) {
    return {std::exp(-height_m / molecule_height_m), std::exp(-height_m / aerosol_height_m),
            std::max(0.0f, 1.0f - std::abs(height_m - 25e3f) / 15e3f)};
}
float height_m(const vec3& at) { return glm::length(at) - earth_radius_m; }

float way_out_m(const vec3& from, const vec3& direction) {
    const float along = glm::dot(from, direction);
    return std::sqrt(along * along - glm::dot(from, from) + air_radius_m * air_radius_m) - along;
}
bool earth_is_before(const vec3& from, const vec3& direction) {
    const float along = glm::dot(from, direction);
    return direction.z < 0.0f && along * along >= glm::dot(from, from) - earth_radius_m * earth_radius_m;
}

/// Densities added up along a ray to where the air ends, metres.
vec3 column_m(const vec3& from, const vec3& direction) {
    // Gauss-Laguerre of order 8, divided by 25, so that the last point is still in the air; weights times exp(x).
    constexpr std::array<float, 8> at = {0.006811185292f, 0.03614807107f, 0.09004346519f, 0.1706680068f,
                                         0.2818362161f,   0.4303406404f,  0.6296271457f,  0.9145252695f};
    constexpr std::array<float, 8> weight = {0.01750893642f, 0.04135477391f, 0.06678839063f, 0.09507698807f,
                                             0.1283416365f,  0.1707430204f,  0.2327233347f,  0.3562490486f};
    const float length_m = way_out_m(from, direction);
    vec3 sum(0.0f);
    for (std::size_t point = 0; point < at.size(); ++point)
        sum += weight[point] * densities(height_m(from + at[point] * length_m * direction));
    return length_m * sum;
}

float molecule_phase(float cosine) { return 3.0f / (16.0f * pi) * (1.0f + cosine * cosine); }
float aerosol_phase(float cosine) {
    constexpr float g = mie_asymmetry;
    return 3.0f * (1.0f - g * g) * (1.0f + cosine * cosine) /
           (8.0f * pi * (2.0f + g * g) * std::pow(1.0f + g * g - 2.0f * g * cosine, 1.5f));
}

vec3 from_angles(float elevation_rad, float longitude_rad) {
    return {std::cos(elevation_rad) * std::cos(longitude_rad), std::cos(elevation_rad) * std::sin(longitude_rad),
            std::sin(elevation_rad)};
}
vec3 eye(const Air& air) { return {0.0f, 0.0f, earth_radius_m + std::clamp(air.altitude_m, 1.0f, 59999.0f)}; }

/// What is scattered once towards the eye.
vec3 scattered_xyz(const Air& air, const vec3& direction, const vec3& to_sun) {
    const Sunlight& light = sunlight();
    const vec3 amount(air.molecules, air.aerosols, air.ozone);
    const float cosine = glm::dot(direction, to_sun);
    const float by_molecules = molecule_phase(cosine), by_aerosols = aerosol_phase(cosine) * aerosol_scattering_per_m;
    const float step_m = way_out_m(eye(air), direction) / view_step_count;
    vec3 passed_m(0.0f);
    Spectrum radiance{};
    for (int step = 0; step < view_step_count; ++step) {
        const vec3 at = eye(air) + (static_cast<float>(step) + 0.5f) * step_m * direction;
        const vec3 density = amount * densities(height_m(at));
        passed_m += step_m * density;
        if (earth_is_before(at, to_sun))
            continue;
        const vec3 depth_m = passed_m + amount * column_m(at, to_sun);
        for (std::size_t index = 0; index < wavelength_count; ++index) {
            const float rayleigh = light.molecule_scattering_per_m[index];
            const float optical_depth = depth_m.x * rayleigh +
                                        depth_m.y * aerosol_extinction_per_scattering * aerosol_scattering_per_m +
                                        depth_m.z * light.ozone_absorption_per_m[index];
            radiance[index] += std::exp(-optical_depth) * light.irradiance_per_nm[index] * step_m *
                               (density.x * rayleigh * by_molecules + density.y * by_aerosols);
        }
    }
    return to_xyz(radiance);
}
} // namespace

vec3 single_scattering_sun(const Air& air, float elevation_rad) {
    const Sunlight& light = sunlight();
    const vec3 depth_m = column_m(eye(air), from_angles(elevation_rad, 0.0f)); // without ozone, as in Cycles
    Spectrum irradiance{};
    for (std::size_t index = 0; index < wavelength_count; ++index)
        irradiance[index] =
            light.irradiance_per_nm[index] *
            std::exp(-depth_m.x * light.molecule_scattering_per_m[index] * air.molecules -
                     depth_m.y * aerosol_extinction_per_scattering * aerosol_scattering_per_m * air.aerosols);
    return to_xyz(irradiance);
}

std::vector<vec3> single_scattering_picture(Model model, const Air& air, float sun_elevation_rad,
                                            const Progress& progress) {
    constexpr std::uint32_t width = picture_width, half_width = width / 2, rows = picture_height / 2;
    const vec3 to_sun = from_angles(sun_elevation_rad, 0.0f);
    const float highest_rad = 0.5f * pi * (model == Model::SingleScattering3 ? 1.0f + 0.5f / rows : 1.0f);
    std::vector<vec3> pixels(std::size_t{width} * 2 * rows);
    parallel_for(
        rows, progress,
        [&](std::size_t row) {
            const float height = static_cast<float>(row) / rows, elevation_rad = highest_rad * height * height;
            vec3* line = &pixels[(rows + row) * width];
            for (std::uint32_t column = 0; column < half_width; ++column) {
                const float longitude = 2.0f * pi * static_cast<float>(column) / width - pi;
                line[column] = line[width - 1 - column] =
                    scattered_xyz(air, from_angles(elevation_rad, longitude), to_sun);
            }
        },
        4);
    // Below the horizon its colour fades to black, at 24 degrees.
    for (std::uint32_t row = 0; row < rows; ++row) {
        const float middle = (static_cast<float>(row) + (model == Model::SingleScattering3 ? 0.5f : 0.0f)) / rows;
        const float depth = std::sin(0.5f * pi * (middle - 1.0f) * (middle - 1.0f));
        const float fade = depth < 0.4f ? std::pow(1.0f - 2.5f * depth, 3.0f) : 0.0f;
        for (std::uint32_t column = 0; column < width; ++column)
            pixels[row * width + column] = fade * pixels[std::size_t{rows} * width + column];
    }
    return pixels;
}
} // namespace tyndall::sky::detail
