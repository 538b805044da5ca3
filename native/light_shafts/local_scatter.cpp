// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/local_scatter.hpp"
#include "scene/medium_cuts.hpp"
#include <algorithm>
#include <array>

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

Rgb LocalScatter::source(const Prepared& prepared, const Stretch& stretch, double angle_rad) const {
    const double x = prepared.softened_y * std::tan(angle_rad); // along the ray from the foot of the light
    const double t = std::clamp(prepared.light_x + x, stretch.near_m, stretch.far_m);
    const double distance_m = std::sqrt(x * x + prepared.light_y * prepared.light_y);
    dvec3 light_sigma_t = sigma_t_at_light_;
    for (std::uint32_t index = 0; index < stretch.crossing_count; ++index) {
        const Crossing& crossing = prepared.crossings[prepared.crossing_of_stretch[stretch.first_crossing + index]];
        // Share of the way to the light at which it meets the boundary.
        const double share =
            (crossing.c - crossing.a * t) / (crossing.a * (prepared.light_x - t) + crossing.b * prepared.light_y);
        light_sigma_t += share * crossing.signed_sigma_t;
    }
    const dvec3 depth = stretch.camera_depth_at_near + stretch.sigma_t * (t - stretch.near_m) +
                        glm::max(light_sigma_t, dvec3(0.0)) * distance_m;
    const vec3 from_light((dvec3(prepared.origin) - dvec3(light_.position) + t * dvec3(prepared.direction)));
    const float length = glm::length(from_light);
    Rgb intensity = light_.strength;
    if (light_.spot != nullptr || light_.emission_normal != vec3(0.0f))
        intensity = length > 0.0f ? intensity_w_per_sr(light_, from_light / length) : Rgb(0.0f);
    if (light_.softening_m2 > 0.0f) { // the strata of a facing disc measure the inverse square from its centre
        const vec3 from_centre = from_light - light_.falloff_offset;
        const double softened = x * x + prepared.softened_y * prepared.softened_y; // what the angles divide by
        intensity *= static_cast<float>(softened / (glm::dot(from_centre, from_centre) + light_.softening_m2));
    }
    const Rgb transmittance =
        depth.x == depth.y && depth.y == depth.z ? Rgb(std::exp(static_cast<float>(-depth.x))) : glm::exp(Rgb(-depth));
    // The light's way makes the angle's complement with the ray; on to the camera it goes against it.
    const auto cosine = static_cast<float>(std::clamp(-x / distance_m, -1.0, 1.0));
    return intensity * transmittance * media_.scatter_per_m_sr(stretch.set, cosine);
}

namespace {
/// Gauss's 7 points and Kronrod's 15 on [-1, 1] (QUADPACK, qk15), positive half.
constexpr std::array<double, 8> kronrod_at = {0.991455371120812639206854697526329, 0.949107912342758524526189684047851,
                                              0.864864423359769072789712788640926, 0.741531185599394439863864773280788,
                                              0.586087235467691130294144691693384, 0.405845151377397166906606412076961,
                                              0.207784955007898467600689403773245, 0.0};
constexpr std::array<double, 8> kronrod_weight = {
    0.022935322010529224963732008058970, 0.063092092629978553290700663189204, 0.104790010322250183839876322541518,
    0.140653259715525918745189590510238, 0.169004726639267902826583426598550, 0.190350578064785409913256402421014,
    0.204432940075298892414161999234649, 0.209482141084727828012999174891714};
constexpr std::array<double, 4> gauss_weight = {
    0.129484966168869693270611432679082, 0.279705391489276667901467771423780, 0.381830050505118944950369775488975,
    0.417959183673469387755102040816327};
} // namespace

Rgb LocalScatter::over_angles(const Prepared& prepared, const Stretch& stretch, double from_rad, double to_rad,
                              int halvings_left) const {
    const double middle = 0.5 * (from_rad + to_rad), half = 0.5 * (to_rad - from_rad);
    dvec3 kronrod(0.0), gauss(0.0);
    for (std::size_t point = 0; point < kronrod_at.size(); ++point) {
        dvec3 value(source(prepared, stretch, middle + half * kronrod_at[point]));
        if (kronrod_at[point] != 0.0)
            value += dvec3(source(prepared, stretch, middle - half * kronrod_at[point]));
        kronrod += kronrod_weight[point] * value;
        if (point % 2 == 1)
            gauss += gauss_weight[point / 2] * value;
    }
    const dvec3 difference = glm::abs(kronrod - gauss);
    // The difference is Gauss's error; Kronrod's is about its 1.5th power.
    constexpr double tolerance = 3e-4;
    if (halvings_left == 0 || glm::all(glm::lessThanEqual(difference, tolerance * kronrod)))
        return Rgb(half * kronrod);
    return over_angles(prepared, stretch, from_rad, middle, halvings_left - 1) +
           over_angles(prepared, stretch, middle, to_rad, halvings_left - 1);
}

Rgb LocalScatter::scattered(const Prepared& prepared, float near_m, float far_m) const {
    Rgb radiance(0.0f);
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
        radiance += over_angles(prepared, stretch, from, to, most_halvings) * static_cast<float>(1.0 / y);
    }
    return radiance;
}
} // namespace tyndall::light_shafts
