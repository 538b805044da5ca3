// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/local_scatter.hpp"
#include "scene/medium_cuts.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace tyndall::light_shafts {
LocalScatter::LocalScatter(const Media& media, const LightSample& light, bool attenuates_light)
    : media_(media), light_(light), attenuates_light_(attenuates_light) {
    Rgb sigma_s(0.0f);
    for (const Medium& medium : media.scene().description().media)
        sigma_s += medium.sigma_s_per_m();
    is_black_ = media.is_empty() || light.strength * sigma_s == Rgb(0.0f);
    if (!attenuates_light)
        return;
    // Any direction tells which media hold the light; this one lies in no plane that modellers favour.
    std::vector<MediumSegment> segments;
    media.segments({.origin = light.position, .direction = glm::normalize(vec3(0.36f, 0.48f, 0.8f))}, segments);
    if (!segments.empty() && segments.front().near_m == 0.0f)
        sigma_t_at_light_ = dvec3(media.sigma_t_per_m(segments.front().set));
}

static bool holds(const MediumBoundary& boundary, const vec3& point) {
    const vec3 at(boundary.object_from_world * vec4(point, 1.0f));
    return glm::all(glm::greaterThanEqual(at, boundary.object_bounds.min)) &&
           glm::all(glm::lessThanEqual(at, boundary.object_bounds.max));
}

void LocalScatter::append_crossings(const ViewRay& ray, const LocalPlane& plane, Prepared& prepared) const {
    thread_local std::vector<MediumCut> cuts;
    for (const MediumBoundary& boundary : media_.boundaries()) {
        // A convex box that holds the light and the ray has nothing between them: a lamp in its own fog.
        if (boundary.is_box && holds(boundary, light_.position) &&
            holds(boundary, ray.origin + ray.near_m * ray.direction) &&
            holds(boundary, ray.origin + ray.far_m * ray.direction))
            continue;
        MediumSet alone;
        alone.insert(boundary.medium);
        const dvec3 sigma_t(media_.sigma_t_per_m(alone));
        const Instance& instance = media_.scene().description().instances[boundary.instance];
        const auto in_object = plane.coordinates.in_object(instance.world_from_object);
        const dvec3 light(glm::dmat4(boundary.object_from_world) * glm::dvec4(dvec3(light_.position), 1.0));
        cuts.clear();
        append_medium_cuts(media_.scene().description(), boundary, in_object, cuts);
        for (const MediumCut& cut : cuts) {
            auto [x0, y0, x1, y1] = cut.segment;
            const double a = y1 - y0, b = x0 - x1, c = a * x0 + b * y0;
            const double top = plane.light_y * (1.0 - 1e-9);
            if (std::max(y0, y1) <= 0.0 || std::min(y0, y1) >= top || (y0 == y1 && x0 == x1))
                continue;
            const auto clip = [](double& x, double& y, double other_x, double other_y, double to_y) {
                x += (to_y - y) / (other_y - y) * (other_x - x);
                y = to_y;
            };
            if (y0 < 0.0)
                clip(x0, y0, x1, y1, 0.0);
            if (y1 < 0.0)
                clip(x1, y1, x0, y0, 0.0);
            if (y0 > top)
                clip(x0, y0, x1, y1, top);
            if (y1 > top)
                clip(x1, y1, x0, y0, top);
            const auto onto_ray = [&](double x, double y) { return x + y * (x - plane.light_x) / (plane.light_y - y); };
            const double t0 = onto_ray(x0, y0), t1 = onto_ray(x1, y1);
            const double near = std::max<double>(std::min(t0, t1), ray.near_m);
            const double far = std::min<double>(std::max(t0, t1), ray.far_m);
            if (!(near < far))
                continue;
            const bool leaves = glm::dot(cut.outward_normal, light - cut.point) > 0.0;
            prepared.crossings.push_back({near, far, a, b, c, leaves ? sigma_t : -sigma_t});
            prepared.splits.push_back(near);
            prepared.splits.push_back(far);
        }
    }
}

/// Real roots of a t^2 + 2 b t + c, appended.
static void append_roots(double a, double b, double c, std::vector<double>& roots) {
    const double discriminant = b * b - a * c;
    if (discriminant < 0.0)
        return;
    const double q = -(b + std::copysign(std::sqrt(discriminant), b));
    if (a != 0.0)
        roots.push_back(q / a);
    if (q != 0.0)
        roots.push_back(c / q);
}

void LocalScatter::append_splits_of_shape(const ViewRay& ray, std::vector<double>& splits) const {
    const dvec3 from_light = dvec3(ray.origin) - dvec3(light_.position), along(ray.direction);
    if (light_.emission_normal != vec3(0.0f)) {
        const dvec3 normal(light_.emission_normal);
        if (const double slope = glm::dot(normal, along); slope != 0.0)
            splits.push_back(-glm::dot(normal, from_light) / slope);
    }
    if (light_.spot == nullptr)
        return;
    const Light& spot = *light_.spot;
    glm::dmat3 in_light(1.0);
    dvec3 axis(spot.spot_axis);
    if (spot.spot_falloff != SpotFalloff::Blender3)
        in_light = glm::dmat3(spot.light_from_world_directions), axis = dvec3(0.0, 0.0, -1.0);
    const dvec3 p = in_light * from_light, v = in_light * along;
    const double outer = std::cos(spot.spot_half_angle_rad);
    const double inner = outer + (1.0 - outer) * spot.spot_blend;
    for (const double cosine : {outer, inner}) { // (axis . u)^2 = cosine^2 |u|^2, on both nappes: one split too many
        const double pa = glm::dot(p, axis), va = glm::dot(v, axis), k = cosine * cosine;
        append_roots(va * va - k * glm::dot(v, v), va * pa - k * glm::dot(v, p), pa * pa - k * glm::dot(p, p), splits);
    }
}

void LocalScatter::prepare(const ViewRay& ray, std::span<const MediumSegment> segments, Prepared& prepared) const {
    prepared.stretches.clear(), prepared.crossings.clear();
    prepared.crossing_of_stretch.clear(), prepared.splits.clear();
    if (segments.empty())
        return;
    const LocalPlane plane = plane_through(ray.origin, ray.direction, light_.position);
    prepared.light_x = plane.light_x, prepared.light_y = plane.light_y;
    prepared.softened_y = std::sqrt(plane.light_y * plane.light_y + double{light_.softening_m2});
    prepared.origin = ray.origin, prepared.direction = ray.direction;
    const ViewRay inside{ray.origin, ray.direction, segments.front().near_m, segments.back().far_m};
    if (attenuates_light_)
        append_crossings(inside, plane, prepared);
    append_splits_of_shape(ray, prepared.splits);
    std::ranges::sort(prepared.splits);
    dvec3 camera_depth(0.0);
    auto split = prepared.splits.begin();
    for (const MediumSegment& segment : segments) {
        const dvec3 sigma_t(media_.sigma_t_per_m(segment.set));
        double from = segment.near_m;
        while (from < segment.far_m) {
            while (split != prepared.splits.end() && !(*split > from))
                ++split;
            const double to = split == prepared.splits.end() ? segment.far_m : std::min<double>(segment.far_m, *split);
            const double middle = 0.5 * (from + to);
            const auto first = static_cast<std::uint32_t>(prepared.crossing_of_stretch.size());
            for (std::uint32_t crossing = 0; crossing < prepared.crossings.size(); ++crossing)
                if (prepared.crossings[crossing].near_m < middle && middle < prepared.crossings[crossing].far_m)
                    prepared.crossing_of_stretch.push_back(crossing);
            const auto count = static_cast<std::uint32_t>(prepared.crossing_of_stretch.size()) - first;
            prepared.stretches.push_back({from, to, segment.set, sigma_t, camera_depth, first, count});
            camera_depth += sigma_t * (to - from);
            from = to;
        }
    }
}

AngularSource LocalScatter::source(const Prepared& prepared, const Stretch& stretch,
                                   std::vector<AngularSource::Crossing>& crossings,
                                   std::vector<AngularSource::Lobe>& lobes) const {
    crossings.clear(), lobes.clear();
    bool is_grey = stretch.sigma_t == dvec3(stretch.sigma_t.x) &&
                   stretch.camera_depth_at_near == dvec3(stretch.camera_depth_at_near.x) &&
                   sigma_t_at_light_ == dvec3(sigma_t_at_light_.x);
    for (std::uint32_t index = 0; index < stretch.crossing_count; ++index) {
        const Crossing& crossing = prepared.crossings[prepared.crossing_of_stretch[stretch.first_crossing + index]];
        crossings.push_back({crossing.a, crossing.b, crossing.c, crossing.signed_sigma_t});
        is_grey = is_grey && crossing.signed_sigma_t == dvec3(crossing.signed_sigma_t.x);
    }
    for (std::size_t index = 0; index < stretch.set.count; ++index)
        for (const ScatterLobe& lobe : media_.scene().description().media[stretch.set.media[index]].lobes) {
            const double g = lobe.asymmetry_g;
            lobes.push_back(
                {dvec3(lobe.sigma_s_per_m) * ((1.0 - g * g) * 0.25 * std::numbers::inv_pi), 1.0 + g * g, 2.0 * g});
        }
    AngularSource source{.softened_y = prepared.softened_y,
                         .light_x = prepared.light_x,
                         .light_y = prepared.light_y,
                         .near_m = stretch.near_m,
                         .far_m = stretch.far_m,
                         .camera_depth_at_near = stretch.camera_depth_at_near,
                         .sigma_t = stretch.sigma_t,
                         .sigma_t_at_light = sigma_t_at_light_,
                         .is_grey = is_grey,
                         .crossings = crossings,
                         .lobes = lobes,
                         .start = dvec3(prepared.origin) - dvec3(light_.position),
                         .along = dvec3(prepared.direction),
                         .has_normal = light_.emission_normal != vec3(0.0f),
                         .is_soft = light_.softening_m2 > 0.0f,
                         .has_spot = light_.spot != nullptr,
                         .normal = dvec3(light_.emission_normal),
                         .falloff_offset = dvec3(light_.falloff_offset),
                         .softening_m2 = double{light_.softening_m2}};
    if (light_.spot != nullptr) {
        const Light& spot = *light_.spot;
        const double cos_half = std::cos(spot.spot_half_angle_rad), smooth = (1.0 - cos_half) * spot.spot_blend;
        const bool is_old = spot.spot_falloff == SpotFalloff::Blender3;
        glm::dmat3 in_cone = glm::dmat3(spot.light_from_world_directions); // shines along -Z
        if (is_old) {
            const auto [u, v] = orthonormal_basis(-spot.spot_axis);
            in_cone = glm::transpose(glm::dmat3(dvec3(u), dvec3(v), -dvec3(spot.spot_axis)));
        }
        const glm::dmat3 turned = glm::dmat3(dvec3(1, 0, 0), dvec3(0, 1, 0), dvec3(0, 0, -1)) * in_cone;
        source.spot = {turned * source.start, turned * source.along, cos_half, smooth > 0.0 ? 1.0 / smooth : 0.0,
                       is_old};
    }
    return source;
}

static dvec3 over_angles(const AngularSource& source, double from_rad, double to_rad, int halvings_left) {
    const auto [kronrod, gauss] = integrate_angles(source, from_rad, to_rad);
    // The difference is Gauss's error; Kronrod's is about its 1.5th power.
    constexpr double tolerance = 3e-4;
    if (halvings_left == 0 || glm::all(glm::lessThanEqual(glm::abs(kronrod - gauss), tolerance * kronrod)))
        return kronrod;
    const double middle = 0.5 * (from_rad + to_rad);
    return over_angles(source, from_rad, middle, halvings_left - 1) +
           over_angles(source, middle, to_rad, halvings_left - 1);
}

Rgb LocalScatter::scattered(const Prepared& prepared, float near_m, float far_m) const {
    thread_local std::vector<AngularSource::Crossing> crossings;
    thread_local std::vector<AngularSource::Lobe> lobes;
    dvec3 sum(0.0);
    for (const Stretch& stretch : prepared.stretches) {
        const double near = std::max<double>(near_m, stretch.near_m), far = std::min<double>(far_m, stretch.far_m);
        if (!(near < far))
            continue;
        const double y = prepared.softened_y, x0 = near - prepared.light_x, x1 = far - prepared.light_x;
        // The end that lies nearer to the light's foot has the better arctangent; the other follows by the difference.
        const double angle_between = std::atan2(y * (x1 - x0), y * y + x0 * x1);
        double from = std::atan2(x0, y), to = std::atan2(x1, y);
        if (std::abs(x0) < std::abs(x1))
            to = from + angle_between;
        else
            from = to - angle_between;
        constexpr int most_halvings = 10;
        sum += over_angles(source(prepared, stretch, crossings, lobes), from, to, most_halvings) / y;
    }
    return light_.strength * Rgb(sum);
}
} // namespace tyndall::light_shafts
