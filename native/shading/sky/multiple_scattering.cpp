// SPDX-License-Identifier: GPL-3.0-or-later
// Based on: Garcia Linan, fgarlin.com/posts/2024-12-06-spectral_sky (four wavelengths and a fit of what is scattered more
//           than once); Hillaire 2020, A Scalable and Production Ready Sky and Atmosphere Rendering Technique (steps whose
//           source is integrated); the air and the grid of blender/cycles v5.0.0, third_party/sky.
// Differs:  nothing that is seen: the transmittance to the sun is a table of the same size, read in between.
// Bound:    of Earth's air: the fit of multiple scattering knows no other densities.
#include "core/parallel.hpp"
#include "shading/sky/sky_model.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall::sky::detail {
namespace {
constexpr float earth_radius_km = 6371.0f, thickness_km = 100.0f, air_radius_km = earth_radius_km + thickness_km;
constexpr float ground_albedo = 0.3f, aerosol_asymmetry = 0.8f;
constexpr int step_count = 64;
constexpr std::size_t table_width = 256, table_height = 64;

// At 630, 560, 490 and 430 nm.
constexpr vec4 sun_irradiance(1.679f, 1.828f, 1.986f, 1.307f);
constexpr vec4 molecule_scattering_per_km(6.605e-3f, 1.067e-2f, 1.842e-2f, 3.156e-2f);
constexpr vec4 ozone_absorption(3.472e-25f, 3.914e-25f, 1.349e-25f, 11.03e-27f);
constexpr vec4 aerosol_absorption(2.8722e-24f, 4.6168e-24f, 7.9706e-24f, 1.3578e-23f);
constexpr vec4 aerosol_scattering(1.5908e-22f, 1.7711e-22f, 2.0942e-22f, 2.4033e-22f);
constexpr float ozone_dobson = 334.5f;
constexpr float aerosol_count = 1.3681e20f, aerosol_background_share = 2e6f / 1.3681e20f, aerosol_height_km = 0.73f;
/// Of the sky's radiance at zenith that was scattered more than once, per irradiance and scattering.
constexpr vec4 scattered_again(0.217f, 0.347f, 0.594f, 1.0f);
constexpr float scattered_again_scale = 0.02f;

vec3 to_xyz(const vec4& spectrum) {
    return spectrum.x * vec3(53.386917738564668f, 22.981337506691025f, 0.0f) +
           spectrum.y * vec3(43.904844466369358f, 71.347795700053394f, 0.102506867965741f) +
           spectrum.z * vec3(1.613727825160896f, 18.422960591455485f, 31.742921188390806f) +
           spectrum.w * vec3(20.762668673810577f, 2.361421352331437f, 110.480096432521403f);
}

vec4 exp4(const vec4& v) { return {std::exp(v.x), std::exp(v.y), std::exp(v.z), std::exp(v.w)}; }

/// Along a ray to a sphere around the Earth's middle, km; below 0: it misses.
float way_to_sphere_km(const vec3& from, const vec3& direction, float radius_km) {
    const float along = glm::dot(from, direction), outside = glm::dot(from, from) - radius_km * radius_km;
    const float under_root = along * along - outside;
    if ((outside > 0.0f && along > 0.0f) || under_root < 0.0f)
        return -1.0f;
    const float root = std::sqrt(under_root);
    return under_root >= along * along ? root - along : -along - root;
}

struct Coefficients {
    vec4 molecules{0.0f}, aerosols{0.0f}, extinction{0.0f}; ///< Scattering and all, per km.
};

class Atmosphere {
public:
    explicit Atmosphere(const Air& air) : air_(air) {}

    /// From there to where the air ends, towards a sun at this cosine from the zenith.
    [[nodiscard]] vec4 transmittance(float cosine, float height_share) const {
        const vec3 from(0.0f, 0.0f, glm::mix(earth_radius_km, air_radius_km, height_share));
        const vec3 direction = to_sun(cosine);
        const float step_km = way_to_sphere_km(from, direction, air_radius_km) / step_count;
        vec4 depth(0.0f);
        for (int step = 0; step < step_count; ++step)
            depth += step_km * at(height_km(from + (static_cast<float>(step) + 0.5f) * step_km * direction)).extinction;
        return exp4(-depth);
    }

    void fill_table(const Progress& progress) {
        table_.resize(table_width * table_height);
        parallel_for(
            table_height, progress,
            [&](std::size_t row) {
                for (std::size_t column = 0; column < table_width; ++column)
                    table_[row * table_width + column] =
                        transmittance(2.0f * static_cast<float>(column) / (table_width - 1) - 1.0f,
                                      static_cast<float>(row) / (table_height - 1));
            },
            4);
    }

    /// What the air scatters towards the eye. The table must be filled.
    [[nodiscard]] vec4 scattered(const vec3& sun, const vec3& from, const vec3& direction) const {
        const float ground_km = way_to_sphere_km(from, direction, earth_radius_km);
        const float length_km = ground_km < 0.0f ? way_to_sphere_km(from, direction, air_radius_km) : ground_km;
        const float step_km = length_km / step_count, cosine = glm::dot(direction, sun);
        constexpr float g = aerosol_asymmetry;
        const float by_molecules = 3.0f / (16.0f * pi) * (1.0f + cosine * cosine),
                    by_aerosols = 0.25f / pi * (1.0f - g * g) / std::pow(1.0f + g * g - 2.0f * g * cosine, 1.5f);
        vec4 radiance(0.0f), passing(1.0f);
        for (int step = 0; step < step_count; ++step) {
            const vec3 place = from + (static_cast<float>(step) + 0.5f) * step_km * direction;
            const float radius_km = glm::length(place), sun_cosine = glm::dot(place, sun) / radius_km;
            const float height = std::max(radius_km - earth_radius_km, 0.0f);
            const Coefficients air = at(height);
            const vec4 sunlit = lookup(sun_cosine, height / thickness_km);
            const vec4 again = scattered_more_than_once(sun_cosine, height / thickness_km, radius_km);
            const vec4 source = sun_irradiance * (air.molecules * (by_molecules * sunlit + again) +
                                                  air.aerosols * (by_aerosols * sunlit + again));
            const vec4 passing_step = exp4(-step_km * air.extinction);
            radiance += passing * source * (1.0f - passing_step) / glm::max(air.extinction, vec4(1e-7f));
            passing *= passing_step;
        }
        return radiance;
    }

    static vec3 to_sun(float cosine) { return {-std::sqrt(std::max(0.0f, 1.0f - cosine * cosine)), 0.0f, cosine}; }

private:
    static float height_km(const vec3& place) { return std::max(glm::length(place) - earth_radius_km, 0.0f); }

    [[nodiscard]] Coefficients at(float height) const {
        const float aerosols =
            air_.aerosols * aerosol_count * (std::exp(-height / aerosol_height_km) + aerosol_background_share);
        const float log_height = std::log(std::max(height, 1e-4f)), from_layer = log_height - 3.22261f;
        const float ozone =
            air_.ozone * ozone_dobson * 3.78547397e20f * std::exp(-from_layer * from_layer * 5.55555555f - log_height);
        Coefficients all{.molecules = air_.molecules * std::exp(-0.07771971f * std::pow(height, 1.16364243f)) *
                                      molecule_scattering_per_km,
                         .aerosols = aerosols * aerosol_scattering};
        all.extinction = all.molecules + all.aerosols + aerosols * aerosol_absorption + ozone * ozone_absorption;
        return all;
    }

    [[nodiscard]] vec4 lookup(float cosine, float height_share) const {
        const auto split = [](float share, std::size_t count) {
            const float place = std::clamp(share, 0.0f, 1.0f) * static_cast<float>(count - 1);
            const auto low = static_cast<std::size_t>(place);
            return std::tuple(low, std::min(low + 1, count - 1), place - static_cast<float>(low));
        };
        const auto [left, right, x] = split(0.5f * cosine + 0.5f, table_width);
        const auto [low, high, y] = split(height_share, table_height);
        const vec4 *lower = &table_[low * table_width], *upper = &table_[high * table_width];
        return glm::mix(glm::mix(lower[left], lower[right], x), glm::mix(upper[left], upper[right], x), y);
    }

    /// By the ground, which is seen from here under a solid angle, and, by a fit, by all other air; per scattering.
    [[nodiscard]] vec4 scattered_more_than_once(float cosine, float height_share, float radius_km) const {
        const float sine = earth_radius_km / radius_km;
        const float earth_sr = 2.0f * pi * (1.0f - std::sqrt(std::max(0.0f, 1.0f - sine * sine)));
        const vec4 to_ground = lookup(1.0f, 0.0f) / lookup(1.0f, height_share);
        const vec4 by_ground = 0.25f / pi * earth_sr * ground_albedo / pi * cosine * lookup(cosine, 0.0f) * to_ground;
        const vec4 by_air = scattered_again_scale / (1.0f + 5.0f * std::exp(-17.92f * cosine)) * scattered_again;
        return by_air + by_ground;
    }

    Air air_;
    std::vector<vec4> table_;
};

float altitude_km(const Air& air) { return std::clamp(air.altitude_m, 1.0f, 99999.0f) / 1000.0f; }
} // namespace

vec3 multiple_scattering_sun(const Air& air, float elevation_rad) {
    return to_xyz(sun_irradiance *
                  Atmosphere(air).transmittance(std::sin(elevation_rad), altitude_km(air) / thickness_km));
}

std::vector<vec3> multiple_scattering_picture(const Air& air, float sun_elevation_rad, const Progress& progress) {
    Atmosphere atmosphere(air);
    atmosphere.fill_table(progress);
    const vec3 sun = Atmosphere::to_sun(std::sin(sun_elevation_rad));
    const vec3 eye(0.0f, 0.0f, earth_radius_km + altitude_km(air));
    constexpr std::uint32_t width = picture_width, height = picture_height;
    std::vector<vec3> pixels(std::size_t{width} * height);
    parallel_for(
        height, progress,
        [&](std::size_t row) {
            const float share = 2.0f * (static_cast<float>(row) + 0.5f) / height - 1.0f;
            const float elevation = std::copysign(share * share, share) * 0.5f * pi;
            for (std::uint32_t column = 0; column < width / 2; ++column) {
                const float azimuth = 2.0f * pi * (static_cast<float>(column) + 0.5f) / width;
                const vec3 direction(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                                     std::sin(elevation));
                pixels[row * width + column] = pixels[row * width + width - 1 - column] =
                    to_xyz(atmosphere.scattered(sun, eye, direction));
            }
        },
        4);
    return pixels;
}
} // namespace tyndall::sky::detail
