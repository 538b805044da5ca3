// SPDX-License-Identifier: GPL-3.0-or-later
#include "volume/air_texture.hpp"
#include "volume/painted_kernel.hpp"
#include <algorithm>

namespace tyndall {
namespace {
/// Four texels per step: measured, the least error; half as many and twice as many have half as much again and a tenth
/// more (benchmarks/heterogeneity_bench.cpp).
constexpr float texels_per_step_log2 = 2.0f;

/// No edge of the cube, no diagonal of its faces, lies near an axis of the scene.
const glm::dmat3 cube_from_scene_directions =
    glm::dmat3(glm::rotate(glm::dmat4(1.0), 0.6, dvec3(0, 0, 1)) *
               glm::rotate(glm::dmat4(1.0), 0.8, glm::normalize(dvec3(1.0, 2.0, 0.5))));
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
    double place = 0.5;
    for (std::uint32_t step = 0; step < most_points(); ++step) {
        place += 0.6180339887498949; // of any length these lie evenly
        place -= std::floor(place);
        sequence_.push_back(std::min(static_cast<float>(place), 0.9999999f));
    }
}

float AirTexture::least_voxel_m() const {
    float least_m = std::numeric_limits<float>::infinity();
    if (!heterogeneity_.painted)
        return least_m;
    const mat3 scene_from_unit = glm::inverse(mat3(heterogeneity_.unit_from_scene));
    const PaintedAir& painted = *heterogeneity_.painted;
    for (const PaintedVolume* volume : {&painted.amount(), &painted.level(), &painted.intensity()})
        for (std::size_t axis = 0; !volume->is_empty() && axis < 3; ++axis)
            least_m = std::min(least_m, glm::length(scene_from_unit[static_cast<glm::length_t>(axis)]) /
                                            static_cast<float>(volume->size[axis]));
    return least_m;
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

void AirTexture::find_paint(const AirSteps& steps, float first_m, float last_m, Paint& paint) const {
    const PaintedAir& painted = *heterogeneity_.painted;
    const vec3 origin(heterogeneity_.unit_from_scene * vec4(steps.origin, 1.0f)),
        direction(heterogeneity_.unit_from_scene * vec4(steps.direction, 0.0f));
    const auto begin = std::ranges::lower_bound(steps.at_m, first_m),
               end = std::ranges::upper_bound(steps.at_m, last_m);
    const auto first = static_cast<std::size_t>(begin - steps.at_m.begin());
    const auto sample = [&](const PaintedVolume& volume, bool is_painted, float otherwise, std::vector<float>& values) {
        values.assign(steps.at_m.size(), otherwise);
        if (!is_painted || begin >= end)
            return;
        painted::VolumeRay ray{.values = volume.values.data(), .size = volume.size, .origin = {}, .direction = {}};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto size = static_cast<float>(volume.size[axis]);
            ray.origin[axis] = origin[static_cast<glm::length_t>(axis)] * size - 0.5f;
            ray.direction[axis] = direction[static_cast<glm::length_t>(axis)] * size;
        }
        painted::sample_along(ray, &*begin, &steps.weights[first], static_cast<std::size_t>(end - begin),
                              &values[first]);
    };
    sample(painted.amount(), !painted.amount().is_empty(), 0.0f, paint.amount);
    sample(painted.level(), painted.changes_level(), 0.0f, paint.level);
    sample(painted.intensity(), painted.changes_intensity(), 1.0f, paint.intensity);
}

float AirTexture::find_levels(const AirSteps& steps, const Paint& paint, float least_level,
                              std::vector<std::uint8_t>& levels) const {
    const auto coarsest = static_cast<float>(noise_->level_count() - 1);
    float finest = coarsest;
    levels.assign(steps.at_m.size(), 0);
    for (std::size_t step = 0; step < levels.size(); ++step) {
        if (steps.weights[step] == 0.0f)
            continue;
        const float level = std::clamp(std::max(heterogeneity_.level + paint.level[step], least_level), 0.0f, coarsest);
        finest = std::min(finest, level);
        levels[step] = static_cast<std::uint8_t>(std::min(level + sequence_[steps.first + step], coarsest));
    }
    return finest;
}

float AirTexture::at(const vec3& point, float least_level, float sequence) const {
    float amount = heterogeneity_.amount, intensity = heterogeneity_.intensity, level = heterogeneity_.level;
    if (heterogeneity_.painted) {
        const vec3 place(heterogeneity_.unit_from_scene * vec4(point, 1.0f));
        if (glm::all(glm::greaterThanEqual(place, vec3(0.0f))) && glm::all(glm::lessThanEqual(place, vec3(1.0f)))) {
            constexpr std::array at_m{0.0f}, weights{1.0f};
            thread_local Paint paint;
            find_paint({point, vec3(0.0f), at_m, weights, 0.0f}, 0.0f, 0.0f, paint);
            amount = std::clamp(amount + paint.amount[0], 0.0f, 1.0f);
            intensity *= paint.intensity[0];
            level += paint.level[0];
        }
    }
    if (amount == 0.0f)
        return intensity;
    level = std::max(level, least_level);
    return intensity * (1.0f + amount * (noise_at(point, level, sequence) - 1.0f));
}

air_noise::NoiseRay AirTexture::noise_ray(const AirSteps& steps, float level) const {
    level = std::clamp(level, 0.0f, static_cast<float>(noise_->level_count() - 1));
    const auto finest = static_cast<std::uint32_t>(level);
    const std::span<const air_noise::PackedLevel> packed = noise_->packed(finest);
    const dvec3 origin = cube_from_scene_ * dvec3(steps.origin) + offset_;
    const dvec3 direction = cube_from_scene_ * dvec3(steps.direction);
    air_noise::NoiseRay ray{.corners = noise_->corners(),
                            .levels = {packed[finest], packed[std::min<std::size_t>(finest + 1, packed.size() - 1)]},
                            .second_share = level - static_cast<float>(finest),
                            .origin = {},
                            .direction = {},
                            .at_m = steps.at_m.data(),
                            .weights = steps.weights.data(),
                            .sequence = sequence_.data() + steps.first,
                            .all_levels = packed.data(),
                            .count = steps.at_m.size()};
    for (glm::length_t axis = 0; axis < 3; ++axis) {
        ray.origin[static_cast<std::size_t>(axis)] = static_cast<float>(origin[axis] - std::floor(origin[axis]));
        ray.direction[static_cast<std::size_t>(axis)] = static_cast<float>(direction[axis]);
    }
    return ray;
}

/// Where a ray is in the unit cube: from .first to .second, which is before it where it misses.
static std::pair<float, float> within_unit_cube(const vec3& origin, const vec3& direction) {
    const vec3 a = -origin / direction, b = (1.0f - origin) / direction;
    const vec3 near = glm::min(a, b), far = glm::max(a, b);
    return {std::max({near.x, near.y, near.z}), std::min({far.x, far.y, far.z})};
}

std::pair<float, float> AirTexture::painted_part(const AirSteps& steps) const {
    constexpr std::pair none{std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()};
    if (!heterogeneity_.painted)
        return none;
    const auto [first_m, last_m] = within_unit_cube(vec3(heterogeneity_.unit_from_scene * vec4(steps.origin, 1.0f)),
                                                    vec3(heterogeneity_.unit_from_scene * vec4(steps.direction, 0.0f)));
    return last_m < steps.at_m.front() || steps.at_m.back() < first_m || !(first_m <= last_m)
               ? none
               : std::pair{first_m, last_m};
}

float AirTexture::mean(const AirSteps& steps) const {
    const float least_level = std::log2(steps.step_m / texel_m_) - texels_per_step_log2;
    if (const auto [first_m, last_m] = painted_part(steps); first_m <= last_m)
        return mean_of_painted(steps, least_level, first_m, last_m);
    const float amount = heterogeneity_.amount;
    if (amount == 0.0f)
        return heterogeneity_.intensity;
    const auto [weights, noise] = air_noise::sum_along(noise_ray(steps, std::max(heterogeneity_.level, least_level)));
    return weights > 0.0f ? heterogeneity_.intensity * (1.0f + amount * (noise / weights - 1.0f)) : 1.0f;
}

void AirTexture::find(const AirSteps& steps, std::span<float> values) const {
    const float least_level = std::log2(steps.step_m / texel_m_) - texels_per_step_log2;
    const auto [first_m, last_m] = painted_part(steps);
    const bool is_painted = first_m <= last_m, has_levels = is_painted && heterogeneity_.painted->changes_level();
    struct Workspace {
        Paint paint;
        std::vector<std::uint8_t> levels;
    };
    thread_local Workspace of_steps;
    const Paint& paint = of_steps.paint;
    if (is_painted)
        find_paint(steps, first_m, last_m, of_steps.paint);
    const float finest = has_levels ? find_levels(steps, paint, least_level, of_steps.levels)
                                    : std::max(heterogeneity_.level, least_level);
    if (is_painted || heterogeneity_.amount > 0.0f) {
        air_noise::NoiseRay ray = noise_ray(steps, finest);
        if (has_levels)
            ray.level_of_step = of_steps.levels.data();
        air_noise::find_along(ray, values.data());
    }
    for (std::size_t step = 0; step < steps.at_m.size(); ++step) {
        float amount = heterogeneity_.amount, intensity = heterogeneity_.intensity;
        if (is_painted) {
            amount = std::clamp(amount + paint.amount[step], 0.0f, 1.0f);
            intensity *= paint.intensity[step];
        }
        const float noise = amount == 0.0f ? 1.0f : values[step];
        values[step] = steps.weights[step] == 0.0f ? 0.0f : intensity * (1.0f + amount * (noise - 1.0f));
    }
}

float AirTexture::mean_of_painted(const AirSteps& steps, float least_level, float first_m, float last_m) const {
    struct Workspace {
        Paint paint;
        std::vector<float> weights;
        std::vector<std::uint8_t> levels;
    };
    thread_local Workspace of_noise;
    of_noise.weights.resize(steps.at_m.size());
    const Paint& paint = of_noise.paint;
    find_paint(steps, first_m, last_m, of_noise.paint);
    float even = 0.0f, weight_sum = 0.0f;
    for (std::size_t step = 0; step < steps.at_m.size(); ++step) {
        const float amount = std::clamp(heterogeneity_.amount + paint.amount[step], 0.0f, 1.0f);
        const float weight = steps.weights[step], bright = weight * paint.intensity[step];
        weight_sum += weight;
        even += bright * (1.0f - amount);
        of_noise.weights[step] = bright * amount;
    }
    if (weight_sum == 0.0f)
        return 1.0f;
    const bool has_levels = heterogeneity_.painted->changes_level();
    air_noise::NoiseRay ray = noise_ray(steps, has_levels ? find_levels(steps, paint, least_level, of_noise.levels)
                                                          : std::max(heterogeneity_.level, least_level));
    ray.weights = of_noise.weights.data();
    if (has_levels)
        ray.level_of_step = of_noise.levels.data();
    return heterogeneity_.intensity * (even + air_noise::sum_along(ray).noise) / weight_sum;
}
} // namespace tyndall
