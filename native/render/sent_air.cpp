// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/sent_air.hpp"
#include "core/sampling.hpp"
#include "light_shafts/lamp_inside.hpp"
#include "render/glow_distances.hpp"
#include "render/many_lights.hpp"
#include "render/pixel_samples.hpp"
#include "scene/light_texture.hpp"
#include <algorithm>
#include <array>
#include <limits>

namespace tyndall::render {
/// Far behind those of lights on surfaces, and of what glows in fog.
static constexpr std::uint32_t first_air_pair = 0x3000'0000;
enum class AirPair : std::uint32_t { Lamp, LampPlace, LampDepth, Sun, SunPlace, World, WorldDirection, WorldImage };

static vec2 air_pair(const FogGlow::Numbers& numbers, AirPair pair) {
    return pixel_pair(numbers.pixel_seed, numbers.draw, first_air_pair + static_cast<std::uint32_t>(pair));
}

SentAir::SentAir(const Scene& scene, const Media& media, const MeshEmitters& emitters, const Config& config,
                 KeptLightTrees* kept)
    : scene_(scene), media_(media), config_(config),
      has_world_(config.world_scatters && scene.world().scatters_in_media()) {
    if (config.has_glow) {
        Statistics unread; // counts and reports are those of the camera's light shafts
        glow_.emplace(scene, media, emitters, config.attenuates_light, unread, kept);
    }
    std::vector<LightBounds> bounds;
    float sum = 0.0f;
    for (std::uint32_t index = 0; index < scene.lights().size(); ++index) {
        const Light& light = scene.lights()[index];
        if (!light.scatters_in_media || light.strength == Rgb(0.0f) ||
            !(light.kind == LightKind::Sun ? config.has_suns : config.has_lamps))
            continue;
        if (light.kind != LightKind::Sun) {
            lamps_.push_back(index);
            bounds.push_back(bounds_of(light));
            continue;
        }
        suns_.push_back(index);
        sun_shares_.push_back(sum += average(light.strength));
    }
    for (float& share : sun_shares_)
        share /= sum;
    tree_ = tree_of(std::move(bounds), kept);
}

std::vector<std::uint8_t> SentAir::light_groups() const {
    std::vector<std::uint8_t> groups;
    const auto add = [&](std::uint8_t group) {
        if (std::ranges::find(groups, group) == groups.end())
            groups.push_back(group);
    };
    for (const std::vector<std::uint32_t>* const lights : {&lamps_, &suns_})
        for (const std::uint32_t index : *lights)
            add(scene_.lights()[index].light_group);
    if (has_world_)
        add(scene_.world().light_group());
    return groups;
}

Rgb SentAir::scattered(const MediaLine& line, const Place& place, const Light& light, const vec3& towards_light,
                       float far_m, const Rgb& irradiance) const {
    const LightLinks* const links =
        light.links.lights_all() && light.links.is_blocked_by_all() ? nullptr : &light.links;
    const Rgb radiance = irradiance * line.scatter_per_m_sr(place.piece, place.at_m, towards_light, links) *
                         line.transmittance(place.piece, place.at_m) / place.density_per_m;
    if (radiance == Rgb(0.0f))
        return radiance;
    const Ray ray{.origin = line.origin() + place.at_m * line.direction(),
                  .direction = towards_light,
                  .near_m = 0.0f,
                  .far_m = far_m};
    if (!light.casts_shadow)
        return radiance;
    return radiance * passing_along(scene_, config_.attenuates_light ? &media_ : nullptr, ray, links);
}

/// Where a spot's cone from a place on it, or what lies before an area light, has the line: a part of it, or all.
static GlowDistances::Reach reach_of(const MediaLine& line, const Light& light, const vec3& place) {
    constexpr float unbounded = std::numeric_limits<float>::infinity();
    constexpr GlowDistances::Reach all{-unbounded, unbounded}, nothing{0.0f, 0.0f};
    const dvec3 way(line.origin() - place), direction(line.direction());
    if (light.kind == LightKind::Area) {
        const double before = glm::dot(way, dvec3(light.spot_axis)), step = glm::dot(direction, dvec3(light.spot_axis));
        if (step == 0.0)
            return before > 0.0 ? all : nothing;
        const auto cut_m = static_cast<float>(-before / step);
        return step > 0.0 ? GlowDistances::Reach{cut_m, unbounded} : GlowDistances::Reach{-unbounded, cut_m};
    }
    constexpr float widest_rad = 1.5f; // beyond, a cone may have a line twice
    if (light.kind != LightKind::Spot || light.spot_half_angle_rad > widest_rad)
        return all;
    const bool is_round = light.spot_falloff == SpotFalloff::Blender3;
    const glm::dmat3 to_cone = is_round ? glm::dmat3(1.0) : glm::dmat3(light.light_from_world_directions);
    const dvec3 axis = is_round ? dvec3(light.spot_axis) : dvec3(0, 0, -1), from = to_cone * way,
                along = to_cone * direction;
    // Eberly, Intersection of a Line and a Cone, 2000: (axis . v)^2 >= cos^2 v . v, before the apex.
    const double cosine = std::cos(double{light.spot_half_angle_rad}), cosine2 = cosine * cosine;
    const double height = glm::dot(axis, from), rise = glm::dot(axis, along);
    const double a = rise * rise - cosine2 * glm::dot(along, along),
                 b = height * rise - cosine2 * glm::dot(from, along),
                 c = height * height - cosine2 * glm::dot(from, from), discriminant = b * b - a * c;
    if (discriminant <= 0.0 || a == 0.0)
        return a > 0.0 && rise != 0.0 ? all : nothing;
    const double root = std::sqrt(discriminant);
    const double first_m = std::min((-b - root) / a, (-b + root) / a),
                 last_m = std::max((-b - root) / a, (-b + root) / a);
    if (a < 0.0) // it leaves the cone that it comes into
        return height + 0.5 * (first_m + last_m) * rise > 0.0
                   ? GlowDistances::Reach{static_cast<float>(first_m), static_cast<float>(last_m)}
                   : nothing;
    return rise > 0.0 ? GlowDistances::Reach{static_cast<float>(last_m), unbounded}
                      : GlowDistances::Reach{-unbounded, static_cast<float>(first_m)};
}

void SentAir::draw_lamp(const MediaLine& line, const FogGlow::Numbers& numbers,
                        std::vector<FogGlow::Found>& found) const {
    const vec2 u = air_pair(numbers, AirPair::Lamp);
    const auto [chosen, probability] = tree_->choose_along(tree_line(line), u.x);
    if (chosen == LightTree::none)
        return;
    const Light& light = scene_.lights()[lamps_[chosen]];
    const vec2 u_place = air_pair(numbers, AirPair::LampPlace);
    const bool is_spot = light.kind == LightKind::Spot;
    LightSample sample; // of a spot first of all: its cone is that of the place
    if (is_spot)
        sample = sample_light(light, lamps_[chosen], vec3(u_place, air_pair(numbers, AirPair::LampDepth).x));
    const float size_m = light.kind == LightKind::Area ? glm::length(light.half_size_m) : light.radius_m;
    const GlowDistances::Reach reach = reach_of(line, light, is_spot ? sample.position : light.position);
    const GlowDistances::Distance distance =
        GlowDistances(line, light.position, size_m, reach, config_.attenuates_light ? &media_ : nullptr).at(u.y);
    if (!(distance.pdf_per_m > 0.0f))
        return;
    const vec3 point = line.origin() + distance.at_m * line.direction();
    if (!is_spot)
        sample = sample_light_towards(light, lamps_[chosen], u_place, point);
    if (light_shafts::LampInside::shines_in(light))
        light_shafts::LampInside::aim_within(light, point, u_place, sample);
    const vec3 way = sample.position - point;
    const float far_m = glm::length(way);
    if (sample.strength == Rgb(0.0f) || !(far_m > 0.0f))
        return;
    const vec3 towards_light = way / far_m;
    Rgb irradiance = intensity_w_per_sr(sample, -towards_light) * irradiance_per_intensity(sample, point);
    if (light.texture)
        irradiance *= texture_colour(light, sample.position, point);
    found.push_back({scattered(line, {*distance.piece, distance.at_m, distance.pdf_per_m * probability}, light,
                               towards_light, far_m, irradiance),
                     light.light_group});
}

void SentAir::draw_sun(const MediaLine& line, const PhaseDirections& along, const FogGlow::Numbers& numbers,
                       std::vector<FogGlow::Found>& found) const {
    const vec2 u = air_pair(numbers, AirPair::Sun);
    const auto [piece, at_m] = along.distance(u.y);
    if (piece == nullptr)
        return;
    const auto chosen = std::min(
        static_cast<std::size_t>(std::ranges::upper_bound(sun_shares_, u.x) - sun_shares_.begin()), suns_.size() - 1);
    const float probability = sun_shares_[chosen] - (chosen > 0 ? sun_shares_[chosen - 1] : 0.0f);
    const Light& light = scene_.lights()[suns_[chosen]];
    const LightSample sample = sample_light(light, suns_[chosen], vec3(air_pair(numbers, AirPair::SunPlace), 0.5f));
    Rgb irradiance = sample.strength;
    if (light.texture)
        irradiance *= texture_colour(light, light.position, line.origin() + at_m * line.direction());
    found.push_back({scattered(line, {*piece, at_m, along.density_per_m(*piece, at_m) * probability}, light,
                               sample.towards_light, std::numeric_limits<float>::infinity(), irradiance),
                     light.light_group});
}

Rgb SentAir::scattered_of_world(const MediaLine& line, const Place& place, const vec3& direction,
                                const Rgb& radiance) const {
    static const Light open; // which lights all, and is stopped by all
    return scattered(line, place, open, direction, std::numeric_limits<float>::infinity(), radiance);
}

void SentAir::draw_world(const MediaLine& line, const PhaseDirections& along, const FogGlow::Numbers& numbers,
                         std::vector<FogGlow::Found>& found) const {
    const World& world = scene_.world();
    const auto add = [&](const MediaLine::Piece& piece, float at_m, const vec3& direction, const World::Look& look,
                         bool is_of_phase) {
        const float by_phase = along.density(piece, at_m, direction),
                    by_image = world.has_image() ? along.density_per_m(piece, at_m) * look.pdf_per_sr : 0.0f;
        const float density = is_of_phase ? by_phase : by_image;
        if (!(density > 0.0f) || look.radiance == Rgb(0.0f))
            return;
        const float share = power_share(density, is_of_phase ? by_image : by_phase);
        found.push_back(
            {share * scattered_of_world(line, {piece, at_m, density}, direction, look.radiance), world.light_group()});
    };
    const PhaseDirections::Drawn drawn =
        along.at(air_pair(numbers, AirPair::World), air_pair(numbers, AirPair::WorldDirection));
    if (drawn.piece == nullptr)
        return;
    add(*drawn.piece, drawn.at_m, drawn.direction, world.look(drawn.direction), true);
    if (!world.has_image())
        return;
    const World::DirectionSample sample = world.sample(air_pair(numbers, AirPair::WorldImage));
    add(*drawn.piece, drawn.at_m, sample.direction, {sample.radiance, sample.pdf_per_sr}, false);
}

void SentAir::draw(const light_shafts::ViewRay& part, const FogGlow::Numbers& numbers,
                   std::vector<FogGlow::Found>& found) const {
    thread_local MediaLine line;
    line.assign(media_, part, StepLimits{});
    if (!line.is_empty())
        draw(line, numbers, found);
}

void SentAir::draw(const MediaLine& line, const FogGlow::Numbers& numbers, std::vector<FogGlow::Found>& found) const {
    if (!lamps_.empty())
        draw_lamp(line, numbers, found);
    if (!suns_.empty() || has_world_) {
        const PhaseDirections along(line);
        if (!suns_.empty())
            draw_sun(line, along, numbers, found);
        if (has_world_)
            draw_world(line, along, numbers, found);
    }
    if (has_glow())
        glow_->draw(line, numbers, found);
}
} // namespace tyndall::render
