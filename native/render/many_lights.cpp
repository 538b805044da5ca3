// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/many_lights.hpp"
#include "scene/area_light.hpp"
#include "scene/light_axes.hpp"
#include <algorithm>

namespace tyndall::render {
static constexpr float rounding_rad = 0.02f; ///< Around sharp edges of beams.

/// Blender 4 turns and scales directions before a spot's cone is tested: its axis and half angle in the scene, about.
static void set_cone(const Light& spot, LightBounds& bounds) {
    bounds.axis = spot.spot_axis;
    bounds.spread_rad = spot.spot_half_angle_rad;
    if (spot.spot_falloff == SpotFalloff::Blender4) {
        const mat3 to_world = glm::inverse(spot.light_from_world_directions);
        bounds.axis = glm::normalize(to_world * vec3(0, 0, -1));
        bounds.spread_rad = 0.0f;
        const float half_rad = std::min(spot.spot_half_angle_rad, 0.5f * pi);
        for (int step = 0; step < 64; ++step) {
            const float turn = 2.0f * pi * static_cast<float>(step) / 64.0f;
            const vec3 edge = to_world * vec3(std::sin(half_rad) * std::cos(turn), std::sin(half_rad) * std::sin(turn),
                                              -std::cos(half_rad));
            bounds.spread_rad = std::max(
                bounds.spread_rad, std::atan2(glm::length(glm::cross(bounds.axis, edge)), glm::dot(bounds.axis, edge)));
        }
    }
    bounds.spread_rad = std::min(bounds.spread_rad + rounding_rad, pi);
    if (spot.spot_half_angle_rad > 0.5f * pi)
        bounds.spread_rad = pi;
    bounds.reach_rad = rounding_rad;
}

LightBounds bounds_of(const Light& lamp) {
    LightBounds bounds;
    bounds.power = average(lamp.strength);
    if (lamp.kind == LightKind::Area) {
        const mat3 axes = light_axes(lamp);
        for (const float x : {-lamp.half_size_m.x, lamp.half_size_m.x})
            for (const float y : {-lamp.half_size_m.y, lamp.half_size_m.y})
                bounds.box.grow(lamp.position + x * axes[0] + y * axes[1]);
        bounds.axis = lamp.spot_axis;
        bounds.reach_rad = std::min(0.5f * pi, lamp.spot_half_angle_rad + rounding_rad);
        bounds.power *= area_spread(lamp).gain;
        return bounds;
    }
    bounds.box = {lamp.position - vec3(lamp.radius_m), lamp.position + vec3(lamp.radius_m)};
    bounds.spread_rad = pi;
    if (lamp.kind == LightKind::Spot)
        set_cone(lamp, bounds);
    return bounds;
}

ManyLights::ManyLights(const Scene& scene, std::vector<std::uint32_t> lamps,
                       std::shared_ptr<const MeshEmitters> emitters, KeptLightTrees* kept)
    : scene_(scene), lamps_(std::move(lamps)), emitters_(std::move(emitters)) {
    const auto lights_surfaces = [&](std::uint32_t instance) { return !scene.lights_surfaces(instance).are_none(); };
    std::vector<LightBounds> bounds;
    std::vector<Bounds3> boxes;
    for (std::uint32_t number = 0; number < lamps_.size(); ++number) {
        const Light& lamp = scene.lights()[lamps_[number]];
        bounds.push_back(bounds_of(lamp));
        const LightAim aim(lamp);
        wide_of_lamp_.push_back(aim.has_size() ? static_cast<std::uint32_t>(wide_lamps_.size()) : LightTree::none);
        if (!aim.has_size())
            continue;
        wide_lamps_.push_back({number, aim});
        boxes.push_back(bounds.back().box);
    }
    boxes_ = LampBoxes(boxes);
    for (const EmissiveTriangle& triangle : emitters_->triangles()) {
        bounds.push_back(MeshEmitters::bounds_of(triangle));
        if (lights_surfaces(triangle.instance))
            has_glow_ = true;
        else
            bounds.back().power = 0.0f;
    }
    has_glow_ |= std::ranges::any_of(emitters_->met_alone(), lights_surfaces);
    tree_ = tree_of(std::move(bounds), kept);
}

std::optional<ManyLights::Aimed> ManyLights::aim(const SurfacePoint& point, float u_choice, vec2 u_place,
                                                 bool tells_density) const {
    const auto [light, probability] = tree_->choose(point.shading.position, point.shading.shading_normal, u_choice);
    if (light == LightTree::none)
        return std::nullopt;
    std::optional<Aimed> aimed = light < lamps_.size()
                                     ? aim_at_lamp(point, light, u_place, tells_density)
                                     : aim_at_triangle(point, emitters_->triangles()[light - lamps_.size()], u_place);
    if (aimed) {
        aimed->arriving /= probability;
        aimed->pdf_per_sr *= probability;
    }
    return aimed;
}

std::optional<ManyLights::Aimed> ManyLights::aim_at_lamp(const SurfacePoint& point, std::uint32_t number, vec2 u,
                                                         bool tells_density) const {
    const std::uint32_t lamp = lamps_[number];
    const Light& light = scene_.lights()[lamp];
    const vec3& position = point.shading.position;
    LightSample sample = sample_light_towards(light, lamp, u, position);
    if (light.kind == LightKind::Spot)
        sample.spot = nullptr; // its cone is asked where its picture is
    const vec3 way = sample.position - position;
    const float distance_m = glm::length(way);
    if (!(distance_m > 0.0f))
        return std::nullopt;
    const vec3 direction = way / distance_m;
    const float cosine = glm::dot(point.shading.shading_normal, direction);
    if (!(cosine > 0.0f))
        return std::nullopt;
    const vec3 origin = point.spawn.towards(direction), left = sample.position - origin;
    const float far_m = glm::length(left);
    const Rgb arriving = intensity_w_per_sr(sample, -direction) * (irradiance_per_intensity(sample, position) * cosine);
    if (!(far_m > 0.0f) || arriving == Rgb(0.0f))
        return std::nullopt;
    const std::uint32_t wide = tells_density ? wide_of_lamp_[number] : LightTree::none;
    return Aimed{.ray = {.origin = origin, .direction = left / far_m, .near_m = 0.0f, .far_m = far_m},
                 .arriving = arriving,
                 .lamp = &light,
                 .pdf_per_sr = wide == LightTree::none
                                   ? 0.0f
                                   : lamp_hit(wide_lamps_[wide].aim.form(), position, direction).pdf_per_sr,
                 .light_group = light.light_group};
}

void ManyLights::meet_lamps(const Ray& ray, std::vector<LampMet>& met) const {
    met.clear();
    thread_local std::vector<std::uint32_t> near;
    boxes_.find(ray, near);
    for (const std::uint32_t wide : near)
        if (const LampHit hit = lamp_hit(wide_lamps_[wide].aim.form(), ray.origin, ray.direction);
            hit.pdf_per_sr > 0.0f && hit.far_m >= ray.near_m && hit.far_m <= ray.far_m)
            met.push_back({wide_lamps_[wide].number, hit});
}

Ray ManyLights::ray_to(const SurfacePoint& point, const Hit& hit, const vec3& direction) const {
    const vec3 target = scene_.arrival_point(hit, direction), origin = point.spawn.towards(direction);
    const vec3 way = target - origin;
    const float far_m = glm::dot(way, direction) > 0.0f ? glm::length(way) : 0.0f;
    return {.origin = origin,
            .direction = far_m > 0.0f ? way / far_m : direction,
            .far_m = far_m,
            .passed_count = point.passed_count};
}

std::optional<ManyLights::Aimed> ManyLights::aim_at_triangle(const SurfacePoint& point,
                                                             const EmissiveTriangle& triangle, vec2 u) const {
    const vec3& position = point.shading.position;
    const TrianglePoint place = triangle_point(triangle.corners, position, u);
    const vec3 way = place.position - position;
    const float distance_m = glm::length(way);
    if (!(place.pdf_per_sr > 0.0f) || !(distance_m > 0.0f))
        return std::nullopt;
    const vec3 direction = way / distance_m;
    const float cosine = glm::dot(point.shading.shading_normal, direction);
    if (!(cosine > 0.0f))
        return std::nullopt;
    const Hit hit = hit_at(triangle, place.barycentrics, distance_m);
    const Ray there{.origin = position, .direction = direction, .passed_count = point.passed_count};
    const Rgb radiance = MeshEmitters::radiance(scene_, &triangle, there, hit);
    if (radiance == Rgb(0.0f))
        return std::nullopt;
    return Aimed{.ray = ray_to(point, hit, direction),
                 .arriving = radiance * (cosine / place.pdf_per_sr),
                 .instance = triangle.instance,
                 .pdf_per_sr = place.pdf_per_sr,
                 .light_group = scene_.object_info(triangle.instance).light_group,
                 .links = links_of(triangle.instance),
                 .kinds = scene_.lights_surfaces(triangle.instance)};
}

std::optional<ManyLights::Aimed> ManyLights::met(const SurfacePoint& point, const Ray& ray, const Hit& hit) const {
    const EmissiveTriangle* const triangle = emitters_->triangle_of(hit);
    float pdf_per_sr = 0.0f;
    if (triangle != nullptr) {
        const vec3 place = ray.origin + hit.distance_m * ray.direction;
        const auto index = lamps_.size() + static_cast<std::size_t>(triangle - emitters_->triangles().data());
        pdf_per_sr = tree_->probability(static_cast<std::uint32_t>(index), point.shading.position,
                                        point.shading.shading_normal) *
                     triangle_pdf_per_sr(triangle->corners, point.shading.position, place);
    } else if (!emitters_->is_met_alone(hit)) {
        return std::nullopt;
    }
    return Aimed{.ray = ray_to(point, hit, ray.direction),
                 .arriving = MeshEmitters::radiance(scene_, triangle, ray, hit),
                 .instance = hit.instance,
                 .pdf_per_sr = pdf_per_sr,
                 .light_group = scene_.object_info(hit.instance).light_group,
                 .links = links_of(hit.instance),
                 .kinds = scene_.lights_surfaces(hit.instance)};
}
} // namespace tyndall::render
