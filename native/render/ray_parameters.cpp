// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/ray_parameters.hpp"
#include "core/errors.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tyndall::render {
using transfer_functions::Axis;
using transfer_functions::ParameterAxis;

// Rays through the frame that a fitted range is taken from, and the share of their surfaces that it leaves out at either
// end: a single far mountain must not push all else into a corner of the function.
static constexpr std::uint32_t grid_width = 64, grid_height = 36;
static constexpr double left_out = 0.02;

static float luminance(const Rgb& colour) { return glm::dot(colour, Rgb(0.2126f, 0.7152f, 0.0722f)); }

/// That scatters: a sun, if there is one.
static const Light* strongest_light(const Scene& scene) {
    const Light* best = nullptr;
    const auto is_better = [](const Light& light, const Light& than) {
        const bool is_sun = light.kind == LightKind::Sun, was_sun = than.kind == LightKind::Sun;
        return is_sun != was_sun ? is_sun : luminance(light.strength) > luminance(than.strength);
    };
    for (const Light& light : scene.lights())
        if (light.scatters_in_media && (!best || is_better(light, *best)))
            best = &light;
    return best;
}

RayParameters::RayParameters(const Scene& scene, const Camera& camera,
                             std::span<const transfer_functions::WeightedFunction> functions,
                             std::optional<std::uint32_t> reference_light)
    : scene_(scene), camera_(camera) {
    require(!reference_light || *reference_light < scene.lights().size(), "reference_light is ",
            reference_light.value_or(0), ", but the scene has ", scene.lights().size(), " lights");
    light_ = reference_light ? &scene.lights()[*reference_light] : strongest_light(scene);
    if (light_ && (reference_light || light_->kind == LightKind::Sun))
        visibility_light_ = static_cast<std::uint32_t>(light_ - scene.lights().data());
    for (const auto& [function, weight] : functions)
        axes_.push_back({place(function.x), place(function.y)});
}

std::vector<vec2> grid_places_px(const Camera& camera) {
    std::vector<vec2> places_px;
    for (std::uint32_t row = 0; row < grid_height; ++row)
        for (std::uint32_t column = 0; column < grid_width; ++column) {
            const vec2 place_px((static_cast<float>(column) + 0.5f) / grid_width * static_cast<float>(camera.width_px),
                                (static_cast<float>(row) + 0.5f) / grid_height * static_cast<float>(camera.height_px));
            if (camera.ray(place_px.x, place_px.y).exists())
                places_px.push_back(place_px);
        }
    return places_px;
}

void RayParameters::look_around() {
    if (!depths_m_.empty())
        return;
    const double origin_z = scene_.description().origin_in_world.z;
    for (const vec2& place_px : grid_places_px(camera_)) {
        const Ray ray = camera_.ray(place_px.x, place_px.y);
        const Hit hit = scene_.closest_hit(ray);
        if (!hit.is_hit())
            continue;
        const vec3 point = ray.origin + hit.distance_m * ray.direction;
        depths_m_.push_back(camera_.depth_m(point));
        heights_m_.push_back(static_cast<float>(point.z + origin_z));
    }
    std::ranges::sort(depths_m_);
    std::ranges::sort(heights_m_);
}

/// What that share of the values lies below.
static float quantile(std::span<const float> ascending, double share) {
    return ascending[static_cast<std::size_t>(share * static_cast<double>(ascending.size() - 1))];
}

RayParameters::PlacedAxis RayParameters::place(const ParameterAxis& axis) {
    PlacedAxis placed{.axis = axis.axis,
                      .low = axis.low_m,
                      .high = axis.high_m,
                      .waits_for_visibility = axis.axis == Axis::AverageVisibility && axis.is_fitted(),
                      .mask = axis.mask.get()};
    if (axis.axis == Axis::AverageVisibility)
        placed.low = 0.0f, placed.high = axis.full_visibility;
    const bool has_range = axis.axis == Axis::Depth || axis.axis == Axis::MeanLitPosition || axis.axis == Axis::Height;
    if (!has_range || !axis.is_fitted())
        return placed;
    look_around();
    const std::vector<float>& seen = axis.axis == Axis::Height ? heights_m_ : depths_m_;
    if (seen.empty()) { // nothing but sky, which is 1 whatever the range
        placed.low = 0.0f, placed.high = 1.0f;
        return placed;
    }
    placed.low = axis.axis == Axis::MeanLitPosition ? 0.0f : quantile(seen, left_out);
    placed.high = std::max(quantile(seen, 1.0 - left_out), std::nextafter(placed.low, INFINITY));
    return placed;
}

bool RayParameters::fits_visibility() const {
    return std::ranges::any_of(
        axes_, [](const auto& two) { return two[0].waits_for_visibility || two[1].waits_for_visibility; });
}

void RayParameters::fit_visibility(std::vector<float> visibility_of_grid) {
    std::ranges::sort(visibility_of_grid);
    const float most = visibility_of_grid.empty() ? 0.0f : quantile(visibility_of_grid, 1.0 - left_out);
    for (auto& two : axes_)
        for (PlacedAxis& axis : two)
            if (axis.waits_for_visibility)
                axis.high = most > 0.0f ? most : 1.0f;
}

bool RayParameters::asks_for(Axis axis) const {
    return std::ranges::any_of(axes_, [&](const auto& two) { return two[0].axis == axis || two[1].axis == axis; });
}

SeenSurface RayParameters::seen(const PathSample& sample) const {
    return {.depth_m = sample.depth_m,
            .height_m = static_cast<float>(sample.position.z + scene_.description().origin_in_world.z),
            .opacity = 1.0f - average(sample.transmittance)};
}

float RayParameters::light_angle(vec2 place_px) const {
    if (!light_)
        return 1.0f;
    const Ray ray = camera_.ray(place_px.x, place_px.y);
    const vec3 to_light = light_->kind == LightKind::Sun ? light_->towards_light : light_->position - ray.origin;
    // Exact near 0 and pi, unlike an arccosine.
    const float angle = std::atan2(glm::length(glm::cross(ray.direction, to_light)), glm::dot(ray.direction, to_light));
    return angle * std::numbers::inv_pi_v<float>;
}

float RayParameters::along(const PlacedAxis& axis, vec2 place_px, const SeenSurface& surface,
                           const SeenShafts& shafts) const {
    const auto in_range = [&](float value) { return (value - axis.low) / (axis.high - axis.low); };
    const bool is_sky = surface.depth_m == 0.0f;
    switch (axis.axis) {
    case Axis::AverageVisibility:
        return in_range(shafts.visibility);
    case Axis::Depth:
        return is_sky ? 1.0f : in_range(surface.depth_m);
    case Axis::MeanLitPosition:
        return shafts.lit_distance_m == 0.0f ? 0.0f : in_range(shafts.lit_distance_m);
    case Axis::LightAngle:
        return light_angle(place_px);
    case Axis::OpticalDepth:
        return surface.opacity;
    case Axis::Height:
        return is_sky ? 1.0f : in_range(surface.height_m);
    case Axis::Mask:
        break;
    }
    const vec2 size(static_cast<float>(camera_.width_px), static_cast<float>(camera_.height_px));
    return axis.mask ? luminance(Rgb(axis.mask->lookup(place_px / size))) : 0.0f;
}

vec2 RayParameters::at(std::size_t function, vec2 place_px, const SeenSurface& surface,
                       const SeenShafts& shafts) const {
    const auto& [x, y] = axes_[function];
    return glm::clamp(vec2(along(x, place_px, surface, shafts), along(y, place_px, surface, shafts)), 0.0f, 1.0f);
}

SeenShafts sum_of_parts(std::span<const Rgb> weights, std::span<const Rgb> radiance, std::span<const float> visibility,
                        std::span<const light_shafts::LitMoments> moments, std::span<const float> heterogeneity) {
    SeenShafts seen;
    float weight_sum = 0.0f, heterogeneity_sum = 0.0f, lit_length_m = 0.0f, lit_moment_m2 = 0.0f;
    for (std::size_t part = 0; part < weights.size(); ++part) {
        const Rgb& weight = weights[part];
        seen.radiance += weight * radiance[part];
        const float total = weight.x + weight.y + weight.z;
        if (!heterogeneity.empty()) {
            seen.textured_radiance += heterogeneity[part] * weight * radiance[part];
            heterogeneity_sum += total * heterogeneity[part];
        }
        weight_sum += total;
        seen.visibility += visibility.empty() ? 0.0f : total * visibility[part];
        if (!moments.empty()) {
            lit_length_m += total * moments[part].length_m;
            lit_moment_m2 += total * moments[part].moment_m2;
        }
    }
    if (heterogeneity.empty())
        seen.textured_radiance = seen.radiance;
    else if (seen.radiance != Rgb(0.0f))
        seen.heterogeneity = average(seen.textured_radiance) / average(seen.radiance);
    else if (weight_sum > 0.0f)
        seen.heterogeneity = heterogeneity_sum / weight_sum;
    seen.meets_medium = weight_sum > 0.0f;
    seen.visibility = seen.meets_medium ? seen.visibility / weight_sum : 0.0f;
    seen.lit_distance_m = lit_length_m > 0.0f ? lit_moment_m2 / lit_length_m : 0.0f;
    return seen;
}
} // namespace tyndall::render
