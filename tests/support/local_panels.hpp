// SPDX-License-Identifier: GPL-3.0-or-later
// What a local light scatters along a view ray, by a quadrature that knows nothing of smooth pieces: the angle under which
// the light sees the ray in thousands of panels, each point asked for its media box by box, in doubles; the edge of a cone
// is found by bisection.
#pragma once
#include "light_shafts/local_scatter.hpp"
#include "scene/area_light.hpp"
#include "scene/light_axes.hpp"
#include "support/scenes.hpp"
#include <cmath>
#include <numbers>
#include <vector>

namespace tyndall::support {
struct FogBox {
    dvec3 centre, half;
    Medium medium;
};
/// A scene of fog boxes with the media index of each box.
inline std::unique_ptr<Scene> scene_of(const std::vector<FogBox>& boxes) {
    std::vector<Part> parts;
    std::vector<Medium> media;
    for (const FogBox& box : boxes) {
        parts.push_back(
            {.mesh = cube(),
             .world_from_object = translation(vec3(box.centre)) * glm::scale(mat4(1.0f), vec3(box.half)),
             .material = {.name = "fog", .medium_index = static_cast<int>(media.size()), .has_surface = false}});
        media.push_back(box.medium);
    }
    return make_scene(parts, media, {});
}

/// Length of from + s step, s in [0, 1], inside the box.
inline double length_inside(const FogBox& box, const dvec3& from, const dvec3& step) {
    double low = 0.0, high = 1.0;
    for (int axis = 0; axis < 3; ++axis) {
        const double a = box.centre[axis] - box.half[axis] - from[axis], b = a + 2.0 * box.half[axis];
        if (step[axis] == 0.0) {
            if (a > 0.0 || b < 0.0)
                return 0.0;
            continue;
        }
        low = std::max(low, std::min(a / step[axis], b / step[axis]));
        high = std::min(high, std::max(a / step[axis], b / step[axis]));
    }
    return low < high ? (high - low) * glm::length(step) : 0.0;
}
inline dvec3 depth_of_boxes(const std::vector<FogBox>& boxes, const dvec3& from, const dvec3& to) {
    dvec3 depth(0.0);
    for (const FogBox& box : boxes)
        depth += dvec3(box.medium.sigma_t_per_m()) * length_inside(box, from, to - from);
    return depth;
}

inline double spot_share(const Light& spot, const dvec3& from_light) {
    const double cos_half = std::cos(double{spot.spot_half_angle_rad}), smooth = (1.0 - cos_half) * spot.spot_blend;
    const bool is_old = spot.spot_falloff == SpotFalloff::Blender3;
    const dvec3 in_light = glm::normalize(glm::dmat3(spot.light_from_world_directions) * from_light);
    const double cosine = is_old ? glm::dot(from_light, dvec3(spot.spot_axis)) : -in_light.z;
    if (cosine <= cos_half)
        return 0.0;
    const double rise = smooth > 0.0 ? std::min(1.0, (cosine - cos_half) / smooth) : 1.0;
    return rise * rise * (3.0 - 2.0 * rise) * (is_old ? cosine : 1.0);
}

/// What one point of the ray sends to its origin per metre, without the strength.
inline dvec3 scattered_at(const std::vector<FogBox>& boxes, const LightSample& light, const dvec3& origin,
                          const dvec3& direction, double t) {
    const dvec3 point = origin + t * direction, way = point - dvec3(light.position), to_point = glm::normalize(way);
    dvec3 came = to_point;
    double passed_share = 1.0; // of the way to the light
    double intensity =
        light.spot != nullptr && light.spot->kind == LightKind::Spot ? spot_share(*light.spot, to_point) : 1.0;
    dvec3 softened = way - dvec3(light.falloff_offset);
    double softening_m2 = light.softening_m2;
    if (light.sphere_radius_m > 0.0f) {
        // As a point from farther off the sphere sees it, and the whole sphere.
        const double radius_m = light.sphere_radius_m;
        const dvec3 normal(light.emission_normal), from_middle = way + radius_m * normal;
        const double off = glm::length(from_middle) - radius_m, farther = std::hypot(off, std::sqrt(softening_m2));
        const dvec3 axis = glm::normalize(from_middle);
        softened = (radius_m + farther) * axis - radius_m * normal;
        const double way_m = glm::length(softened),
                     fade = std::clamp(2.0 - off * off / (500.0 * softening_m2), 0.0, 1.0);
        const auto cap = [&](double height_m) { return 1.0 - std::cos(std::asin(radius_m / (radius_m + height_m))); };
        const double share = off > 0.0 ? std::lerp(1.0, cap(off) / cap(farther), fade) : 0.0;
        intensity *= share * std::max(0.0, glm::dot(softened, normal) / way_m);
        passed_share = (way_m - (farther - off) * std::sqrt(way_m / farther)) / glm::length(way);
        const double aside = 1.0 - (1.0 - glm::dot(softened, axis) / way_m) * std::max(share, 1.0);
        came = std::max(aside, 0.0) * axis +
               std::sqrt(1.0 - std::pow(std::max(aside, 0.0), 2.0)) * glm::normalize(way - glm::dot(way, axis) * axis);
        softening_m2 = 0.0;
    } else if (light.spot != nullptr && light.spot->kind == LightKind::Area) {
        const dvec3 axis(light.emission_normal);
        const double along = std::hypot(glm::dot(way, axis), std::sqrt(light.softening_m2));
        const double beside = glm::length(glm::cross(way, axis)), half_rad = light.spot->spot_half_angle_rad;
        const double slats = half_rad < 1.5707 ? std::max(0.0, 1.0 - beside / (along * std::tan(half_rad))) : 1.0;
        intensity = glm::dot(way, axis) > 0.0 ? slats * along / std::hypot(along, beside) : 0.0;
        // As a point from farther before the patch sees it.
        const double before = glm::dot(way, axis), way_m = std::hypot(along, beside);
        passed_share = (way_m - (along - before) * std::sqrt(way_m / along)) / glm::length(way);
        // A rectangle's edges, of which both points see the solid angle; faded out from 500 to 1,000 softenings.
        const glm::dmat3 axes(light_axes(*light.spot));
        const dvec3 from_middle = point - dvec3(light.spot->position);
        const dvec2 foot(glm::dot(from_middle, axes[0]), glm::dot(from_middle, axes[1]));
        const double narrow = 1.0 + (half_rad < 1.5707 ? 7.0 / std::tan(half_rad) : 0.0);
        const auto seen_sr = [&](double height_m) {
            const dvec2 half(light.spot->half_size_m);
            return rectangle_solid_angle_sr(-half - foot, half - foot, height_m / narrow);
        };
        const double fade = std::clamp(2.0 - before * before / (500.0 * light.softening_m2), 0.0, 1.0);
        const double edges = before > 0.0 ? std::lerp(1.0, seen_sr(before) / seen_sr(along), fade) : 1.0;
        intensity *= edges;
        const double z = along / way_m, down = edges > 1.0 ? std::max(0.0, 1.0 - (1.0 - z) * edges) : z * edges;
        came = down * axis + std::sqrt(1.0 - down * down) * glm::normalize(way - before * axis);
    } else if (light.emission_normal != vec3(0.0f))
        intensity *= std::max(0.0, glm::dot(to_point, dvec3(light.emission_normal)));
    if (intensity == 0.0)
        return dvec3(0.0);
    intensity /= glm::dot(softened, softened) + softening_m2;
    dvec3 scatter(0.0);
    const double cosine = -glm::dot(came, direction);
    for (const FogBox& box : boxes) {
        if (glm::any(glm::greaterThan(glm::abs(point - box.centre), box.half)))
            continue;
        for (const ScatterLobe& lobe : box.medium.lobes) {
            const double g = lobe.asymmetry_g, alpha = lobe.draine_alpha;
            scatter += dvec3(lobe.sigma_s_per_m) * (1.0 - g * g) * (1.0 + alpha * cosine * cosine) /
                       ((1.0 + alpha * (1.0 + 2.0 * g * g) / 3.0) * 4.0 * std::numbers::pi *
                        std::pow(1.0 + g * g - 2.0 * g * cosine, 1.5));
        }
    }
    return intensity * scatter *
           glm::exp(-depth_of_boxes(boxes, origin, point) -
                    passed_share * depth_of_boxes(boxes, point, dvec3(light.position)));
}

/// Gauss's 3 points on panels of the angle, cut where the light begins and ends.
inline dvec3 integral(const std::vector<FogBox>& boxes, const LightSample& light, const dvec3& origin,
                      const dvec3& direction, double near, double far) {
    const double light_x = glm::dot(dvec3(light.position) - origin, direction);
    const double light_y =
        std::hypot(glm::length(origin + light_x * direction - dvec3(light.position)), std::sqrt(light.softening_m2));
    const auto panel = [&](double a, double b) {
        dvec3 sum(0.0);
        for (const auto [node, weight] :
             {dvec2(-std::sqrt(0.6), 5.0 / 18.0), dvec2(0.0, 8.0 / 18.0), dvec2(std::sqrt(0.6), 5.0 / 18.0)}) {
            const double angle = 0.5 * (a + b) + 0.5 * (b - a) * node, tangent = std::tan(angle);
            sum += weight * (b - a) * light_y * (1.0 + tangent * tangent) *
                   scattered_at(boxes, light, origin, direction, light_x + light_y * tangent);
        }
        return sum;
    };
    const auto is_lit = [&](double angle) {
        return scattered_at(boxes, light, origin, direction, light_x + light_y * std::tan(angle)) != dvec3(0.0);
    };
    const double from = std::atan2(near - light_x, light_y), to = std::atan2(far - light_x, light_y);
    constexpr int panel_count = 6000;
    dvec3 sum(0.0);
    for (int index = 0; index < panel_count; ++index) {
        double a = from + (to - from) * index / panel_count, b = from + (to - from) * (index + 1) / panel_count;
        const bool begins = is_lit(a + 1e-12 * (b - a)), ends = is_lit(b - 1e-12 * (b - a));
        if (begins != ends) {
            double dark = begins ? b : a, lit = begins ? a : b;
            for (int step = 0; step < 50; ++step)
                (is_lit(0.5 * (dark + lit)) ? lit : dark) = 0.5 * (dark + lit);
            (begins ? b : a) = lit;
        }
        sum += panel(a, b);
    }
    return sum;
}

/// View rays with their media, ready to be asked for what a local light scatters along them.
struct MediaRays {
    const Media& media;
    std::vector<light_shafts::ViewRay> rays;
    std::vector<std::uint32_t> first{0};
    std::vector<MediumSegment> segments;

    void add(const light_shafts::ViewRay& ray) {
        rays.push_back(ray);
        media.segments({.origin = ray.origin, .direction = ray.direction, .near_m = ray.near_m, .far_m = ray.far_m},
                       segments);
        first.push_back(static_cast<std::uint32_t>(segments.size()));
    }
    [[nodiscard]] light_shafts::LocalRays columns() const {
        light_shafts::LocalRays local;
        local.assign(media, rays, first, segments);
        return local;
    }
    [[nodiscard]] std::vector<Rgb> ask(const LightSample& light,
                                       const light_shafts::Visibility* visibility = nullptr) const {
        std::vector<Rgb> radiance(rays.size(), Rgb(0.0f));
        light_shafts::LocalScatter(media, light).add_scattered(columns(), visibility, radiance, {}, {});
        return radiance;
    }
};

/// Radiance of one of the rays, all of it lit.
inline dvec3 by_panels(const std::vector<FogBox>& boxes, const LightSample& light, const MediaRays& rays,
                       std::size_t ray) {
    dvec3 sum(0.0);
    for (std::uint32_t at = rays.first[ray]; at < rays.first[ray + 1]; ++at)
        sum += integral(boxes, light, dvec3(rays.rays[ray].origin), dvec3(rays.rays[ray].direction),
                        rays.segments[at].near_m, rays.segments[at].far_m);
    return dvec3(light.strength) * sum;
}

/// Lets light through on [from, to) of every `period_m` of a ray, and remembers what it was asked.
class Stripes final : public light_shafts::Visibility {
public:
    Stripes(float from_m, float to_m, float period_m) : from_m_(from_m), to_m_(to_m), period_m_(period_m) {}
    void lit_intervals(std::span<const light_shafts::ViewRay> rays, light_shafts::LitRows& rows) const override {
        for (const light_shafts::ViewRay& ray : rays) {
            asked.push_back(ray);
            for (float t = 0.0f; t < ray.far_m; t += period_m_) {
                const float near_m = std::max(ray.near_m, t + from_m_), far_m = std::min(ray.far_m, t + to_m_);
                if (near_m < far_m)
                    rows.intervals.push_back({.near_m = near_m, .far_m = far_m});
            }
            rows.end_ray();
        }
    }
    [[nodiscard]] const Statistics& statistics() const override { return statistics_; }
    mutable std::vector<light_shafts::ViewRay> asked;

private:
    float from_m_, to_m_, period_m_;
    Statistics statistics_;
};
} // namespace tyndall::support
