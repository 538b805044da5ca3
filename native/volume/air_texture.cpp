// SPDX-License-Identifier: GPL-3.0-or-later
#include "volume/air_texture.hpp"
#include <algorithm>

namespace tyndall {
namespace {
/// No edge of the cube, no diagonal of its faces, lies near an axis of the scene.
const glm::dmat3 cube_from_scene_directions =
    glm::dmat3(glm::rotate(glm::dmat4(1.0), 0.6, dvec3(0, 0, 1)) *
               glm::rotate(glm::dmat4(1.0), 0.8, glm::normalize(dvec3(1.0, 2.0, 0.5))));

/// Trilinear; `place` in the unit cube. Beyond the outermost samples their values hold.
float sampled(const PaintedVolume& volume, const vec3& place) {
    std::array<std::array<std::size_t, 2>, 3> voxel;
    std::array<float, 3> share;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto last = static_cast<float>(volume.size[axis] - 1);
        const float at = std::clamp(
            place[static_cast<glm::length_t>(axis)] * static_cast<float>(volume.size[axis]) - 0.5f, 0.0f, last);
        voxel[axis][0] = static_cast<std::size_t>(at);
        voxel[axis][1] = std::min<std::size_t>(voxel[axis][0] + 1, volume.size[axis] - 1);
        share[axis] = at - static_cast<float>(voxel[axis][0]);
    }
    const auto between = [](float a, float b, float t) { return a + t * (b - a); };
    const auto row = [&](std::size_t z, std::size_t y) {
        const float* const values =
            &volume.values[(voxel[2][z] * volume.size[1] + voxel[1][y]) * std::size_t{volume.size[0]}];
        return between(values[voxel[0][0]], values[voxel[0][1]], share[0]);
    };
    const auto layer = [&](std::size_t z) { return between(row(z, 0), row(z, 1), share[1]); };
    return between(layer(0), layer(1), share[2]);
}
} // namespace

AirTexture::AirTexture(const Heterogeneity& heterogeneity, const Progress& progress) : heterogeneity_(heterogeneity) {
    require_usable(heterogeneity);
    noise_ = heterogeneity.kept_noise ? heterogeneity.kept_noise->find_or_make(heterogeneity.noise, progress)
                                      : std::make_shared<const AirNoiseVolume>(heterogeneity.noise, progress);
    const double side_m = double{AirNoiseVolume::cells_per_side} * double{heterogeneity.noise.scale_m};
    texel_m_ = static_cast<float>(side_m / heterogeneity.noise.resolution);
    cube_from_scene_ = cube_from_scene_directions / side_m;
    const dvec3 moved = cube_from_scene_ * heterogeneity.moved_m;
    offset_ = glm::ceil(moved) - moved; // wind of years leaves the noise as fine as it was
}

AirTexture AirTexture::weighted(Heterogeneity::Weighting weighting) const {
    AirTexture result = *this;
    result.heterogeneity_.weighting = weighting;
    return result;
}

float AirTexture::noise_at(const vec3& point, float level, float sequence) const {
    const auto nearest = static_cast<std::uint32_t>(std::max(level + sequence, 0.0f));
    return noise_->relative_at(cube_from_scene_ * dvec3(point) + offset_, std::min(nearest, noise_->level_count() - 1));
}

float AirTexture::at(const vec3& point, float least_level, float sequence) const {
    float amount = heterogeneity_.amount, level = heterogeneity_.level, intensity = heterogeneity_.intensity;
    if (const PaintedAir* const painted = heterogeneity_.painted.get()) {
        const vec3 place(heterogeneity_.unit_from_scene * vec4(point, 1.0f));
        if (glm::all(glm::greaterThanEqual(place, vec3(0.0f))) && glm::all(glm::lessThanEqual(place, vec3(1.0f)))) {
            if (!painted->amount().is_empty())
                amount = std::clamp(amount + sampled(painted->amount(), place), 0.0f, 1.0f);
            if (painted->changes_level())
                level += sampled(painted->level(), place);
            if (painted->changes_intensity())
                intensity *= sampled(painted->intensity(), place);
        }
    }
    if (amount == 0.0f)
        return intensity;
    return intensity * (1.0f + amount * (noise_at(point, std::max(level, least_level), sequence) - 1.0f));
}

float AirTexture::mean(const AirSteps& steps) const {
    // Two texels per step: measured, the least error (benchmarks/heterogeneity_bench.cpp).
    const float least_level = std::log2(steps.step_m / texel_m_) - 1.0f;
    float sum = 0.0f, weight_sum = 0.0f;
    double sequence = 0.5;
    for (std::size_t step = 0; step < steps.at_m.size(); ++step) {
        sequence += 0.6180339887498949; // of any length its numbers lie evenly
        sequence -= std::floor(sequence);
        const float weight = steps.weights[step];
        if (weight == 0.0f)
            continue;
        weight_sum += weight;
        sum +=
            weight * at(steps.origin + steps.at_m[step] * steps.direction, least_level, static_cast<float>(sequence));
    }
    return weight_sum > 0.0f ? sum / weight_sum : 1.0f;
}
} // namespace tyndall
