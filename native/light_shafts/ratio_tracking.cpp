// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/ratio_tracking.hpp"
#include "core/random.hpp"
#include "scene/light_texture.hpp"
#include "scene/softened_patch.hpp"
#include <algorithm>
#include <bit>
#include <cmath>

namespace tyndall::light_shafts {
namespace {
constexpr std::uint32_t point_count = 32;

/// Counts up from what a ray is, never from what was drawn before it.
class RandomStream {
public:
    explicit RandomStream(std::uint32_t key) : key_(key) {}
    /// [0, 1).
    [[nodiscard]] float next() { return unit_float(hash(key_, count_++)); }

private:
    std::uint32_t key_, count_ = 0;
};

/// exp(-optical depth of the grids) along the ray, on average.
Rgb ratio_transmittance(const GridMedia& grids, const Ray& ray, RandomStream& random) {
    Rgb passing(1.0f);
    for (const PlacedGrid& placed : grids.all()) {
        const GridLine line = placed.line(ray.origin, ray.direction);
        for_each_brick(*placed.grid, line, ray.near_m, ray.far_m,
                       [&](const DensityGrid::Brick& brick, double near_m, double far_m, const glm::ivec3&) {
                           const Rgb greatest = placed.sigma_t_per_m(brick.greatest);
                           const float majorant = std::max({greatest.x, greatest.y, greatest.z});
                           double at = near_m;
                           while (majorant > 0.0f && (at -= std::log1p(-double{random.next()}) / majorant) < far_m)
                               passing *= 1.0f - placed.sigma_t_per_m(placed.grid->at(vec3(line.at(at)))) / majorant;
                           return passing != Rgb(0.0f);
                       });
    }
    return passing;
}

std::uint32_t key_of(const ViewRay& ray, const LightSample& light, std::uint32_t seed) {
    const auto bits = [](float value) { return std::bit_cast<std::uint32_t>(value); };
    const vec3 place = light.is_directional ? light.towards_light : light.position;
    return hash(bits(ray.direction.x), bits(ray.direction.y), bits(ray.direction.z), bits(ray.origin.x),
                bits(ray.origin.y), bits(ray.origin.z), bits(ray.near_m), bits(place.x), bits(place.y), bits(place.z),
                light.light_index, seed);
}

/// One ray under one light sample.
class Tracker {
public:
    Tracker(const Media& media, const LightSample& light, const ViewRay& ray, std::uint32_t seed)
        : media_(media), light_(light), ray_(ray), random_(key_of(ray, light, seed)) {}

    /// Of the light that reaches the camera from around the point, without what shadows it: radiance per metre.
    [[nodiscard]] Rgb scattered_per_m(double at_m, const MediumSet& set) {
        const vec3 point = ray_.origin + static_cast<float>(at_m) * ray_.direction;
        Ray to_light{.origin = point, .direction = light_.towards_light};
        vec3 from_light = -light_.towards_light;
        Rgb irradiance = light_.strength;
        if (!light_.is_directional) {
            const vec3 way = light_.position - point;
            to_light.far_m = glm::length(way);
            if (!(to_light.far_m > 0.0f) || !is_in_cell(point))
                return Rgb(0.0f);
            to_light.direction = way / to_light.far_m;
            const LocalView view = view_local(light_, point);
            from_light = view.from_light, to_light.far_m = view.distance_m, irradiance = view.irradiance;
        }
        if (light_.textured != nullptr)
            irradiance *= texture_colour(light_, point);
        const Rgb source = irradiance * scatter_per_m_sr(point, set, -glm::dot(ray_.direction, from_light));
        if (source == Rgb(0.0f))
            return source;
        // From the ray's start each time: points then are independent.
        const Rgb result = source * passing({.origin = ray_.origin,
                                             .direction = ray_.direction,
                                             .near_m = ray_.near_m,
                                             .far_m = static_cast<float>(at_m)});
        return light_.is_dimmed_by_media ? result * passing(to_light) : result;
    }
    [[nodiscard]] float random() { return random_.next(); }

private:
    [[nodiscard]] bool is_in_cell(const vec3& point) const {
        return light_.cell == nullptr || std::ranges::all_of(light_.cell->inwards, [&](const vec3& inwards) {
                   return glm::dot(inwards, point - light_.cell->apex) >= 0.0f;
               });
    }
    [[nodiscard]] Rgb scatter_per_m_sr(const vec3& point, const MediumSet& set, float cosine) const {
        Rgb sum = media_.scatter_per_m_sr(set, cosine);
        media_.grids().for_each_density(point, [&](const GridField& field, float density) {
            sum += density * field.density_scale * media_.scatter_per_m_sr(field.medium, cosine);
        });
        return sum;
    }
    [[nodiscard]] Rgb passing(const Ray& ray) {
        return media_.homogeneous_transmittance(ray) * ratio_transmittance(media_.grids(), ray, random_);
    }

    const Media& media_;
    const LightSample& light_;
    const ViewRay& ray_;
    RandomStream random_;
};

Rgb lit_share(std::span<const LitInterval> lit, double at_m) {
    for (const LitInterval& interval : lit)
        if (interval.near_m <= at_m && at_m < interval.far_m)
            return interval.transmittance;
    return Rgb(0.0f);
}
} // namespace

void track_ratios(const Media& media, const LightSample& light, std::uint32_t seed, const TrackedRays& tracked,
                  std::span<Rgb> radiance, std::span<Rgb> unshadowed) {
    for (std::size_t ray = 0; ray < tracked.rays.size(); ++ray) {
        radiance[ray] = Rgb(0.0f);
        if (!unshadowed.empty())
            unshadowed[ray] = Rgb(0.0f);
        const auto segments = tracked.segments.subspan(tracked.first_segment[ray],
                                                       tracked.first_segment[ray + 1] - tracked.first_segment[ray]);
        double length_m = 0.0;
        for (const MediumSegment& segment : segments)
            length_m += double{segment.far_m} - segment.near_m;
        Tracker tracker(media, light, tracked.rays[ray], seed);
        const auto weight = static_cast<float>(length_m / point_count);
        auto segment = segments.begin();
        double before_m = 0.0; // length of the segments before
        for (std::uint32_t index = 0; index < point_count && segment != segments.end(); ++index) {
            const double at = (index + double{tracker.random()}) / point_count * length_m;
            while (segment != segments.end() && before_m + segment->far_m - segment->near_m <= at)
                before_m += double{segment->far_m} - segment->near_m, ++segment;
            if (segment == segments.end())
                break;
            const double at_m = segment->near_m + (at - before_m);
            const Rgb share = lit_share(tracked.lit.of_ray(ray), at_m);
            if (share == Rgb(0.0f) && unshadowed.empty())
                continue;
            const Rgb found = weight * tracker.scattered_per_m(at_m, segment->set);
            radiance[ray] += share * found;
            if (!unshadowed.empty())
                unshadowed[ray] += found;
        }
    }
}
} // namespace tyndall::light_shafts
