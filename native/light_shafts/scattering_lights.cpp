// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/scattering_lights.hpp"
#include "core/random.hpp"
#include "core/sobol.hpp"
#include "light_shafts/dealt_strata.hpp"
#include "light_shafts/local_scatter.hpp"
#include "light_shafts/scatter_pieces.hpp"
#include "scene/area_light.hpp"
#include "scene/light_texture.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tyndall::light_shafts {
/// The digits of a number to base 3, mirrored at the point: in [0, 1).
static double radical_inverse_of_3(std::uint32_t number) {
    double sum = 0.0;
    for (double place = 1.0 / 3.0; number != 0; number /= 3, place /= 3.0)
        sum += place * (number % 3);
    return sum;
}

vec3 stratum(std::uint32_t index, std::uint32_t count, std::uint32_t seed) {
    // Fractions of multiples of powers of one number: successive seeds give well-spread shifts.
    const double shift = 0.5 / count;
    const dvec3 point(index / static_cast<double>(count), reverse_bits(index) * 0x1p-32, radical_inverse_of_3(index));
    const dvec3 turn(0.7548776662466927, 0.5698402909980532, 0.4301597090019467);
    return glm::min(vec3(glm::fract(point + shift + static_cast<double>(seed) * turn)), vec3(0x1.fffffep-1f));
}

/// A stratum of a lamp stands for a patch of its surface, whose area over pi this is.
static float patch_m2(const Light& light, std::uint32_t count) {
    return light.radius_m * light.radius_m / static_cast<float>(count);
}

/// What is added to the square of how far a point lies before a patch of an area light: what passes through any plane is
/// then the patch's light, and on the patch itself as bright as there. Farther off the error falls with 1 / count.
static float softening_of_patch_m2(const Light& light, std::uint32_t count) {
    return area_spread(light).gain * area_m2(light) * std::numbers::inv_pi_v<float> / static_cast<float>(count);
}

LightSample stratum_of(const Light& light, std::uint32_t light_index, std::uint32_t index, std::uint32_t count,
                       std::uint32_t seed) {
    if (light.kind == LightKind::Area) {
        LightSample sample = sample_light(light, light_index, count == 1 ? vec3(0.5f) : stratum(index, count, seed));
        sample.softening_m2 = softening_of_patch_m2(light, count);
        sample.strength *= 1.0f / static_cast<float>(count);
        return sample;
    }
    if (count == 1) {
        Light without_size = light;
        without_size.radius_m = without_size.half_angle_rad = 0.0f;
        LightSample centre = sample_light(without_size, light_index, vec3(0.5f));
        centre.spot = light.kind == LightKind::Spot ? &light : nullptr;
        centre.textured = light.texture ? &light : nullptr;
        return centre;
    }
    LightSample sample = sample_light(light, light_index, stratum(index, count, seed));
    if (light.kind != LightKind::Sun) {
        // A disc that faces the receiver is soft already, save in its middle.
        const bool is_sphere = light.body == LightBody::Sphere;
        sample.softening_m2 =
            is_sphere ? 4.0f * patch_m2(light, count) : std::max(sample.softening_m2, 0.5f * patch_m2(light, count));
        sample.sphere_radius_m = is_sphere ? light.radius_m : 0.0f;
    }
    sample.strength *= 1.0f / static_cast<float>(count);
    return sample;
}

/// Each stratum of an area light shines in the mean colour of its part of the light. Together they send what the whole light
/// sends: few are evened out, and where they miss what it shows by too much, each shines in the mean of all.
static void paint(const Light& light, std::span<LightSample> strata) {
    const auto count = static_cast<std::uint32_t>(strata.size());
    const Rgb whole = mean_colour(light, light.position, 1);
    std::vector<Rgb> colours;
    Rgb sum(0.0f);
    for (const LightSample& stratum : strata)
        sum += colours.emplace_back(mean_colour(light, stratum.position, count));
    for (std::size_t index = 0; index < strata.size(); ++index)
        for (int channel = 0; channel < 3; ++channel) {
            const float evened = whole[channel] * static_cast<float>(count) / sum[channel];
            const bool is_met = evened > 0.5f && evened < 2.0f; // not by a sum of 0
            strata[index].strength[channel] *= is_met ? evened * colours[index][channel] : whole[channel];
        }
}

/// The strata of a lamp with something inside it: points of a disc in each of many cells of directions.
static void add_disc_strata(const Light& light, std::span<const float> weights, std::uint32_t per_quarter,
                            std::uint32_t seed, ScatteringLight& scattering) {
    const auto count = static_cast<std::uint32_t>(weights.size());
    std::vector<vec2> disc;
    std::vector<float> weight;
    for (std::uint32_t index = 0; index < count; ++index) {
        if (weights[index] == 0.0f)
            continue;
        // At random: turns that went with a stratum's place on the disc would be a bias.
        const auto bits = pcg4d({index, count, seed, static_cast<std::uint32_t>(scattering.index)});
        const vec3 turn(unit_float(bits[0]), unit_float(bits[1]), unit_float(bits[2]));
        const std::vector<DiscCell> cells = make_disc_cells(light, per_quarter, turn);
        scattering.parts = cells.size();
        scattering.cells.insert(scattering.cells.end(), cells.begin(), cells.end());
        disc.insert(disc.end(), cells.size(), vec2(stratum(index, count, seed)));
        weight.insert(weight.end(), cells.size(), weights[index]);
    }
    for (std::size_t part = 0; part < scattering.cells.size(); ++part) { // which no longer move
        LightSample sample =
            sample_disc(light, static_cast<std::uint32_t>(scattering.index), scattering.cells[part], disc[part]);
        sample.softening_m2 = std::max(sample.softening_m2, 0.5f * patch_m2(light, count));
        sample.strength *= weight[part] / static_cast<float>(count);
        scattering.samples.push_back(sample);
    }
}

/// Those that are this picture's.
static void deal(std::span<const float> weights, std::vector<LightSample>& samples) {
    std::size_t kept = 0;
    for (std::size_t index = 0; index < samples.size(); ++index)
        if (weights[index] > 0.0f) {
            samples[kept] = samples[index];
            samples[kept++].strength *= weights[index];
        }
    samples.resize(kept);
}

/// Of a light with so many strata, or pictures of it, that average out, the share that is this picture's.
static float dealt_share(std::span<const float> weights, const SeriesPart& part) {
    const auto taken = std::ranges::count_if(weights, [](float weight) { return weight > 0.0f; });
    const float of_strata = static_cast<float>(taken) / static_cast<float>(weights.size());
    const float of_pictures = static_cast<float>(part.end - part.first) / static_cast<float>(part.samples);
    return part.has_own_view ? std::min(of_strata, of_pictures) : of_strata;
}

/// See cells_per_quarter; below 0 for lights that need no cells.
static std::vector<float> weights_of_discs(const Scene& scene, const StrataCounts& counts) {
    std::vector<float> weights(scene.lights().size(), -1.0f);
    float roots = 0.0f;
    for (std::size_t index = 0; index < weights.size(); ++index) {
        const Light& light = scene.lights()[index];
        if (counts.of_light[index] <= 1 || light.kind == LightKind::Sun || light.kind == LightKind::Area ||
            light.body != LightBody::FacingDisc || !light.casts_shadow ||
            !has_occluder_within(scene, light.position, light.radius_m))
            continue;
        weights[index] = counts.shares.empty() ? 1.0f : std::sqrt(counts.shares[index]);
        roots += weights[index];
    }
    for (float& weight : weights)
        if (weight > 0.0f)
            weight *= counts.shares.empty() ? 1.0f : roots;
    return weights;
}

/// A spot whose cone passes by the sphere around all bounded media, or an area light that has them behind it.
static bool misses(const Light& light, const Media& media) {
    if (light.kind == LightKind::Area)
        return !media.fills_world() && glm::dot(media.bounds().centre() - light.position, light.spot_axis) <=
                                           -0.5f * media.bounds().diagonal_m() - glm::length(light.half_size_m);
    if (light.kind != LightKind::Spot || media.fills_world() || light.spot_falloff != SpotFalloff::Blender3)
        return false; // from 4.0 on an object's scale may shear the cone
    const vec3 way = media.bounds().centre() - light.position;
    const float distance_m = glm::length(way), radius_m = 0.5f * media.bounds().diagonal_m() + light.radius_m;
    if (distance_m <= radius_m)
        return false;
    const float angle_rad = std::acos(std::clamp(glm::dot(way / distance_m, light.spot_axis), -1.0f, 1.0f));
    return angle_rad > light.spot_half_angle_rad + std::asin(radius_m / distance_m) + 1e-4f;
}

bool has_size(const Light& light) {
    return light.kind == LightKind::Sun ? light.half_angle_rad > 0.0f
                                        : light.kind == LightKind::Area || light.radius_m > 0.0f;
}

static bool swallows_suns(const Media& media) {
    return DirectionalScatter(media, {}).is_black() &&
           !DirectionalScatter(media, {.is_dimmed_by_media = false}).is_black();
}

std::vector<ScatteringLight> find_scattering_lights(const Scene& scene, const Media& media, const Config& config,
                                                    const StrataCounts& counts, Statistics& statistics) {
    constexpr std::uint32_t least_strata = 4, least_directions = 16; // of a picture of several: what moves shows few
    std::vector<ScatteringLight> lights;
    constexpr const char* remedy = "the world's medium has no end and swallows it: put the fog into a box";
    const std::vector<float> weights = weights_of_discs(scene, counts);
    const bool drowns_suns = config.attenuates_light && swallows_suns(media);
    for (std::uint32_t index = 0; index < scene.lights().size(); ++index) {
        const Light& light = scene.lights()[index];
        if (counts.left.lamps && light.kind != LightKind::Sun)
            continue;
        const std::string what = "light shafts of " + light.name;
        if (!light.scatters_in_media) {
            statistics.skip(what, "switched off");
            continue;
        }
        if (light.strength == Rgb(0.0f)) {
            statistics.skip(what, "no strength");
            continue;
        }
        if (light.kind == LightKind::Sun && light.is_dimmed_by_media() && drowns_suns) {
            statistics.skip(what, remedy);
            statistics.report(light.name + ": no light shafts, " + remedy);
            continue;
        }
        if (misses(light, media)) {
            statistics.skip(what, light.kind == LightKind::Area ? "no medium lies before it"
                                                                : "its cone does not reach a medium");
            continue;
        }
        ScatteringLight& scattering = lights.emplace_back(ScatteringLight{light.name, index, {}});
        const std::uint32_t count = counts.of_light[index];
        const std::vector<float> dealt = dealt_weights(count, least_strata, config.part, config.seed, index);
        scattering.dealt_share = dealt_share(dealt, config.part);
        if (weights[index] >= 0.0f) {
            add_disc_strata(light, dealt, cells_per_quarter(config.error_target, weights[index], count), config.seed,
                            scattering);
            continue;
        }
        for (std::uint32_t sample = 0; sample < count; ++sample)
            scattering.samples.push_back(stratum_of(light, index, sample, count, config.seed));
        if (light.kind == LightKind::Area && light.texture)
            paint(light, scattering.samples);
        deal(dealt, scattering.samples);
    }
    const World& world = scene.world();
    if (!world.scatters_in_media() || counts.left.world)
        return lights;
    if (counts.of_world == 0 || drowns_suns) {
        statistics.skip("light shafts of the world", drowns_suns ? remedy : "switched off");
        return lights;
    }
    ScatteringLight& scattering = lights.emplace_back(ScatteringLight{world.name(), scene.lights().size(), {}});
    const std::vector<float> dealt = dealt_weights(counts.of_world, least_directions, config.part, config.seed,
                                                   static_cast<std::uint32_t>(scattering.index));
    scattering.dealt_share = dealt_share(dealt, config.part);
    for (std::uint32_t sample = 0; sample < counts.of_world; ++sample) {
        if (dealt[sample] == 0.0f)
            continue;
        const World::DirectionSample direction = world.sample(vec2(stratum(sample, counts.of_world, config.seed)));
        if (!(direction.pdf_per_sr > 0.0f) || direction.radiance == Rgb(0.0f))
            continue;
        scattering.samples.push_back(
            {.is_directional = true,
             .towards_light = direction.direction,
             .strength =
                 direction.radiance * (dealt[sample] / (direction.pdf_per_sr * static_cast<float>(counts.of_world))),
             .light_index = static_cast<std::uint32_t>(scene.lights().size())});
    }
    return lights;
}
} // namespace tyndall::light_shafts
