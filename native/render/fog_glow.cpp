// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/fog_glow.hpp"
#include "core/sampling.hpp"
#include "render/glow_distances.hpp"
#include "render/passed_surface.hpp"
#include "render/pixel_samples.hpp"
#include <algorithm>
#include <array>

namespace tyndall::render {
/// Far behind those of lights on surfaces; as many for each part of a ray.
static constexpr std::uint32_t first_pair = 0x2000'0000, first_pair_of_media = 0x3000'0000, pairs_of_part = 4;
/// Surfaces that let light through, on a ray by chance.
static constexpr int most_panes = 16;

static bool scatters(const Medium& medium) { return medium.sigma_s_per_m() != Rgb(0.0f); }

FogGlow::FogGlow(const Scene& scene, const Media& media, const MeshEmitters& emitters, bool attenuates_light,
                 Statistics& statistics, KeptLightTrees* kept)
    : scene_(scene), media_(media), emitters_(emitters), attenuates_light_(attenuates_light) {
    const SceneDescription& description = scene.description();
    if (media.is_empty() || std::ranges::none_of(description.media, scatters))
        return;
    has_glowing_media_ = media.emits();
    for (const std::uint32_t instance : emitters.instances())
        if (scene.lights_media(instance) && !media.grids().is_empty() &&
            !scene.object_info(instance).links.lights_all())
            statistics.report("Object \"" + description.object_names[description.name_index_of(instance)] +
                              "\": light linking does not reach density grids: it lights them all");
    has_met_alone_ =
        std::ranges::any_of(emitters.met_alone(), [&](std::uint32_t instance) { return scene.lights_media(instance); });
    std::vector<LightBounds> bounds;
    for (const EmissiveTriangle& triangle : emitters.triangles()) {
        bounds.push_back(MeshEmitters::bounds_of(triangle));
        if (!scene.lights_media(triangle.instance))
            bounds.back().power = 0.0f;
    }
    const auto count = std::ranges::count_if(bounds, [](const LightBounds& one) { return one.power > 0.0f; });
    if (count == 0)
        return;
    tree_ = tree_of(std::move(bounds), kept);
    statistics.count("glow in fog: triangles", static_cast<double>(count));
}

std::vector<std::uint8_t> FogGlow::light_groups() const {
    std::vector<std::uint8_t> groups;
    if (has_glowing_media_)
        groups.push_back(no_light_group);
    for (const std::uint32_t instance : emitters_.instances()) {
        const std::uint8_t group = scene_.object_info(instance).light_group;
        if (scene_.lights_media(instance) && std::ranges::find(groups, group) == groups.end())
            groups.push_back(group);
    }
    return groups;
}

Rgb FogGlow::passing_to(const vec3& point, const Hit& hit, const vec3& direction, const LightLinks* links) const {
    const vec3 target = scene_.arrival_point(hit, direction), way = target - point;
    const float far_m = glm::length(way);
    if (!(glm::dot(way, direction) > 0.0f))
        return Rgb(1.0f); // nothing fits between
    const Ray ray{.origin = point, .direction = way / far_m, .near_m = 0.0f, .far_m = far_m};
    return passing_along(scene_, attenuates_light_ ? &media_ : nullptr, ray, links);
}

Rgb passing_along(const Scene& scene, const Media* media, const Ray& ray, const LightLinks* links) {
    std::array passing{Rgb(1.0f)};
    if (links == nullptr)
        passing[0] = scene.shadow_transmittance(ray);
    else
        scene.shadow_transmittances({&ray, 1}, passing, *links);
    return media != nullptr && passing[0] != Rgb(0.0f) ? passing[0] * media->transmittance(ray) : passing[0];
}
LightTree::Line tree_line(const MediaLine& line) {
    return {line.origin(), line.direction(), line.pieces().front().near_m, line.pieces().back().far_m,
            line.sigma_t_per_m()};
}
static vec2 pair_of(const FogGlow::Numbers& numbers, std::uint32_t pair, std::uint32_t first = first_pair) {
    return pixel_pair(numbers.pixel_seed, numbers.draw, first + pairs_of_part * numbers.part + pair);
}

void FogGlow::draw(const MediaLine& line, const Numbers& numbers, std::vector<Found>& found) const {
    const bool draws_direction = draws_directions_ || has_met_alone_ || (tree_ != nullptr && line.has_peak());
    if (!draws_direction && !has_glowing_media_)
        return draw_triangle(line, numbers, nullptr, found);
    const PhaseDirections directions(line);
    if (has_glowing_media_)
        draw_media(line, numbers, directions, found);
    if (tree_ != nullptr)
        draw_triangle(line, numbers, draws_direction ? &directions : nullptr, found);
    if (draws_direction)
        draw_direction(line, numbers, directions, found);
}

void FogGlow::draw_triangle(const MediaLine& line, const Numbers& numbers, const PhaseDirections* directions,
                            std::vector<Found>& found) const {
    const vec2 along = pair_of(numbers, 0);
    const auto [index, probability] = tree_->choose_along(tree_line(line), along.x);
    if (index == LightTree::none)
        return;
    const EmissiveTriangle& triangle = emitters_.triangles()[index];
    const GlowDistances::Distance distance =
        GlowDistances(line, triangle, attenuates_light_ ? &media_ : nullptr).at(along.y);
    if (!(distance.pdf_per_m > 0.0f))
        return;
    const vec3 point = line.origin() + distance.at_m * line.direction();
    const TrianglePoint place = triangle_point(triangle.corners, point, pair_of(numbers, 1));
    const vec3 way = place.position - point;
    const float length_m = glm::length(way);
    if (!(place.pdf_per_sr > 0.0f) || !(length_m > 0.0f))
        return;
    const vec3 direction = way / length_m;
    const LightLinks* const links = links_of(triangle.instance);
    const Rgb scattered = line.scatter_per_m_sr(*distance.piece, distance.at_m, direction, links);
    if (scattered == Rgb(0.0f))
        return;
    const Hit hit = hit_at(triangle, place.barycentrics, length_m);
    const Rgb emitted =
        MeshEmitters::radiance(scene_, &triangle, {.origin = point, .direction = direction}, hit, RayKind::Scatter);
    const float density = probability * distance.pdf_per_m * place.pdf_per_sr;
    Rgb arriving = emitted * scattered * line.transmittance(*distance.piece, distance.at_m) / density;
    if (arriving == Rgb(0.0f))
        return;
    if (directions != nullptr && is_met_by_chance(triangle))
        arriving *= power_share(density, directions->density(*distance.piece, distance.at_m, direction));
    found.push_back(
        {arriving * passing_to(point, hit, direction, links), scene_.object_info(triangle.instance).light_group});
}

Rgb FogGlow::met(const MediaLine& line, const PhaseDirections& directions, const PhaseDirections::Drawn& drawn,
                 const Hit& hit) const {
    const EmissiveTriangle* const triangle = emitters_.triangle_of(hit);
    const vec3 point = line.origin() + drawn.at_m * line.direction();
    const LightLinks* const links = links_of(hit.instance);
    const Rgb emitted = MeshEmitters::radiance(scene_, triangle, {.origin = point, .direction = drawn.direction}, hit,
                                               RayKind::Scatter);
    const Rgb scattered = line.scatter_per_m_sr(*drawn.piece, drawn.at_m, drawn.direction, links);
    const float density = directions.density(*drawn.piece, drawn.at_m, drawn.direction);
    const Rgb arriving = emitted * scattered * line.transmittance(*drawn.piece, drawn.at_m) / density;
    if (!(density > 0.0f) || arriving == Rgb(0.0f))
        return Rgb(0.0f);
    const Rgb passing = passing_to(point, hit, drawn.direction, links);
    if (passing == Rgb(0.0f))
        return passing;
    if (triangle == nullptr)
        return arriving * passing;
    const auto index = static_cast<std::uint32_t>(triangle - emitters_.triangles().data());
    const float by_triangle =
        tree_->probability_along(index, tree_line(line)) *
        GlowDistances(line, *triangle, attenuates_light_ ? &media_ : nullptr).density_per_m(*drawn.piece, drawn.at_m) *
        triangle_pdf_per_sr(triangle->corners, point, point + hit.distance_m * drawn.direction);
    return power_share(density, by_triangle) * arriving * passing;
}

static bool casts_shadow(const Scene& scene, const Hit& hit) {
    const PlacedShape* const placed = scene.placed_shape(hit.instance);
    return placed != nullptr ? placed->casts_shadow : scene.description().instances[hit.instance].casts_shadow;
}

void FogGlow::draw_media(const MediaLine& line, const Numbers& numbers, const PhaseDirections& directions,
                         std::vector<Found>& found) const {
    const PhaseDirections::Drawn drawn =
        directions.at(pair_of(numbers, 0, first_pair_of_media), pair_of(numbers, 1, first_pair_of_media));
    if (drawn.piece == nullptr)
        return;
    const float density = directions.density(*drawn.piece, drawn.at_m, drawn.direction);
    Rgb share = line.scatter_per_m_sr(*drawn.piece, drawn.at_m, drawn.direction, nullptr) *
                line.transmittance(*drawn.piece, drawn.at_m);
    if (!(density > 0.0f) || share == Rgb(0.0f))
        return;
    share /= density;
    Ray ray{.origin = line.origin() + drawn.at_m * line.direction(), .direction = drawn.direction, .near_m = 0.0f};
    Rgb radiance(0.0f);
    for (int passed = 0; passed < most_panes && share != Rgb(0.0f); ++passed) {
        const Hit hit = scene_.closest_hit(ray, bounce_mask);
        Ray inside = ray;
        if (hit.is_hit())
            inside.far_m = hit.distance_m;
        radiance += share * media_.emission(inside);
        if (!hit.is_hit())
            break;
        share *= media_.transmittance(inside);
        if (casts_shadow(scene_, hit))
            share *= scene_.transparency(ray, hit);
        go_on_behind(ray, hit);
    }
    found.push_back({radiance, no_light_group});
}

void FogGlow::draw_direction(const MediaLine& line, const Numbers& numbers, const PhaseDirections& directions,
                             std::vector<Found>& found) const {
    const PhaseDirections::Drawn drawn = directions.at(pair_of(numbers, 2), pair_of(numbers, 3));
    if (drawn.piece == nullptr)
        return;
    Ray ray{.origin = line.origin() + drawn.at_m * line.direction(), .direction = drawn.direction, .near_m = 0.0f};
    if (!emitters_.may_meet(ray))
        return;
    for (int passed = 0; passed < most_panes; ++passed) {
        const Hit hit = scene_.closest_hit(ray, bounce_mask);
        if (!hit.is_hit())
            return;
        if (is_met_by_chance(hit))
            found.push_back({met(line, directions, drawn, hit), scene_.object_info(hit.instance).light_group});
        if (casts_shadow(scene_, hit) && scene_.transparency(ray, hit) == Rgb(0.0f))
            return;
        go_on_behind(ray, hit);
    }
}
} // namespace tyndall::render
