// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/fog_glow.hpp"
#include "core/parallel.hpp"
#include "render/glow_distances.hpp"
#include "render/pixel_samples.hpp"
#include <algorithm>
#include <array>
#include <bit>

namespace tyndall::render {
/// Far behind those of lights on surfaces; two pairs for each part of a ray.
static constexpr std::uint32_t first_pair = 0x2000'0000;
/// Of the pilot.
static constexpr std::size_t most_pilot_parts = 512;
static constexpr std::uint32_t pilot_draws = 8;

static bool scatters(const Medium& medium) { return medium.sigma_s_per_m() != Rgb(0.0f); }

FogGlow::FogGlow(const Scene& scene, const Media& media, const MeshEmitters& emitters, bool attenuates_light,
                 Statistics& statistics)
    : scene_(scene), media_(media), emitters_(emitters), attenuates_light_(attenuates_light) {
    const SceneDescription& description = scene.description();
    if (emitters.triangles().empty() || media.is_empty() || std::ranges::none_of(description.media, scatters))
        return;
    std::vector<LightBounds> bounds;
    std::uint32_t reported = ~0u;
    for (const EmissiveTriangle& triangle : emitters.triangles()) {
        bounds.push_back(MeshEmitters::bounds_of(triangle));
        if (!description.instances[triangle.instance].lights_media)
            bounds.back().power = 0.0f;
        else if (!media.grids().is_empty() && triangle.instance != reported &&
                 !scene.object_info(triangle.instance).links.lights_all()) {
            reported = triangle.instance;
            statistics.report("Object \"" + description.object_names[description.name_index_of(triangle.instance)] +
                              "\": light linking does not reach density grids: it lights them all");
        }
    }
    tree_ = LightTree(bounds);
    if (!is_empty())
        statistics.count("glow in fog: triangles", static_cast<double>(std::ranges::count_if(
                                                       bounds, [](const LightBounds& one) { return one.power > 0; })));
}

std::vector<std::uint8_t> FogGlow::light_groups() const {
    std::vector<std::uint8_t> groups;
    std::uint32_t instance = ~0u;
    for (const EmissiveTriangle& triangle : emitters_.triangles()) {
        if (triangle.instance == instance || !scene_.description().instances[triangle.instance].lights_media)
            continue;
        instance = triangle.instance;
        if (const std::uint8_t group = scene_.object_info(instance).light_group;
            std::ranges::find(groups, group) == groups.end())
            groups.push_back(group);
    }
    return groups;
}

Rgb FogGlow::passing_to(const vec3& point, const Hit& hit, const vec3& direction, const LightLinks* links) const {
    const vec3 target = scene_.spawn_point(hit).towards(-direction), way = target - point;
    const float far_m = glm::length(way);
    if (!(glm::dot(way, direction) > 0.0f))
        return Rgb(1.0f); // nothing fits between
    const Ray ray{.origin = point, .direction = way / far_m, .near_m = 0.0f, .far_m = far_m};
    std::array passing{Rgb(1.0f)};
    if (links == nullptr)
        passing[0] = scene_.shadow_transmittance(ray);
    else
        scene_.shadow_transmittances({&ray, 1}, passing, *links);
    return attenuates_light_ && passing[0] != Rgb(0.0f) ? passing[0] * media_.transmittance(ray) : passing[0];
}

FogGlow::Found FogGlow::draw(const MediaLine& line, const Numbers& numbers) const {
    const std::uint32_t pair = first_pair + 2 * numbers.part;
    const vec2 along = pixel_pair(numbers.pixel_seed, numbers.draw, pair);
    const auto [index, probability] = tree_.choose_along({line.origin(), line.direction(), line.pieces().front().near_m,
                                                          line.pieces().back().far_m, line.sigma_t_per_m()},
                                                         along.x);
    if (index == LightTree::none)
        return {};
    const EmissiveTriangle& triangle = emitters_.triangles()[index];
    const GlowDistances::Distance distance =
        GlowDistances(line, triangle, attenuates_light_ ? &media_ : nullptr).at(along.y);
    if (!(distance.pdf_per_m > 0.0f))
        return {};
    const vec3 point = line.origin() + distance.at_m * line.direction();
    const TrianglePoint place =
        triangle_point(triangle.corners, point, pixel_pair(numbers.pixel_seed, numbers.draw, pair + 1));
    const vec3 way = place.position - point;
    const float length_m = glm::length(way);
    if (!(place.pdf_per_sr > 0.0f) || !(length_m > 0.0f))
        return {};
    const vec3 direction = way / length_m;
    const ObjectInfo& info = scene_.object_info(triangle.instance);
    const LightLinks* const links = info.links == LightLinks{} ? nullptr : &info.links;
    const Rgb scattered = line.scatter_per_m_sr(*distance.piece, distance.at_m, direction, links);
    if (scattered == Rgb(0.0f))
        return {};
    Hit hit;
    hit.distance_m = length_m;
    hit.instance = triangle.instance;
    hit.triangle = triangle.triangle;
    hit.barycentrics = place.barycentrics;
    hit.geometric_normal = triangle.normal;
    const Rgb emitted =
        MeshEmitters::radiance(scene_, triangle, {.origin = point, .direction = direction}, hit, RayKind::Scatter);
    const Rgb arriving = emitted * scattered * line.transmittance(*distance.piece, distance.at_m) /
                         (probability * distance.pdf_per_m * place.pdf_per_sr);
    if (arriving == Rgb(0.0f))
        return {};
    return {arriving * passing_to(point, hit, direction, links), info.light_group};
}

std::uint32_t FogGlow::count_draws(std::span<const light_shafts::ViewRay> parts, float error_target,
                                   std::uint32_t pixel_samples, const Progress& progress) const {
    const std::size_t count = std::min(parts.size(), most_pilot_parts);
    struct Sums {
        double variance = 0.0, square = 0.0; ///< Of one draw; of what a part has.
        Sums& operator+=(const Sums& other) {
            variance += other.variance, square += other.square;
            return *this;
        }
    };
    const Sums sums = parallel_sum(count, 32, Sums{}, progress, [&](std::size_t begin, std::size_t end) {
        MediaLine line;
        Sums found;
        for (std::size_t index = begin; index < end; ++index) {
            assign(line, parts[index * parts.size() / count]);
            double sum = 0.0, squares = 0.0;
            for (std::uint32_t draw = 0; !line.is_empty() && draw < pilot_draws; ++draw) {
                const double value =
                    average(this->draw(line, {hash(static_cast<std::uint32_t>(index), draw), 0, 0}).radiance);
                sum += value, squares += value * value;
            }
            const double variance = std::max(0.0, squares - sum * sum / pilot_draws) / (pilot_draws - 1);
            found.variance += variance;
            found.square += std::max(0.0, sum * sum / (pilot_draws * pilot_draws) - variance / pilot_draws);
        }
        return found;
    });
    if (!(sums.variance > 0.0))
        return 1;
    const double wanted = sums.variance / (sums.square * error_target * error_target * pixel_samples);
    return wanted < most_draws ? std::bit_ceil(static_cast<std::uint32_t>(std::max(1.0, std::ceil(wanted))))
                               : most_draws;
}
} // namespace tyndall::render
