// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/local_crossings.hpp"
#include "scene/medium_cuts.hpp"
#include <algorithm>

namespace tyndall::light_shafts {
/// A ray that ends on a face of the box may end outside of it by a rounding: `slack` of the box is as good as inside.
static bool holds(const MediumBoundary& boundary, const vec3& point, float slack) {
    const vec3 at(boundary.object_from_world * vec4(point, 1.0f));
    const vec3 margin = slack * (boundary.object_bounds.max - boundary.object_bounds.min);
    return glm::all(glm::greaterThanEqual(at, boundary.object_bounds.min - margin)) &&
           glm::all(glm::lessThanEqual(at, boundary.object_bounds.max + margin));
}

LightSideBoundaries::LightSideBoundaries(const Media& media, const vec3& light_position) : media_(media) {
    for (const MediumBoundary& boundary : media.boundaries()) {
        MediumSet alone;
        alone.insert(boundary.medium);
        boundaries_.push_back(
            {.boundary = &boundary,
             .light_in_object = dvec3(glm::dmat4(boundary.object_from_world) * glm::dvec4(dvec3(light_position), 1.0)),
             .sigma_t = dvec3(media.sigma_t_per_m(alone)),
             .holds_light = boundary.is_box && holds(boundary, light_position, 0.0f)});
    }
}

/// A convex box that holds the light and the ray has nothing between them: a lamp in its own fog.
static bool is_in_box_with_light(const MediumBoundary& boundary, bool holds_light, const ViewRay& ray) {
    constexpr float slack = 1e-5f;
    return holds_light && holds(boundary, ray.origin + ray.near_m * ray.direction, slack) &&
           holds(boundary, ray.origin + ray.far_m * ray.direction, slack);
}

bool LightSideBoundaries::is_clear(const ViewRay& ray) const {
    return std::ranges::all_of(boundaries_, [&](const Boundary& boundary) {
        return is_in_box_with_light(*boundary.boundary, boundary.holds_light, ray);
    });
}

void LightSideBoundaries::append_crossings(const ViewRay& ray, const LocalPlane& plane,
                                           std::vector<LocalCrossing>& crossings) const {
    thread_local std::vector<MediumCut> cuts;
    for (const Boundary& boundary : boundaries_) {
        if (is_in_box_with_light(*boundary.boundary, boundary.holds_light, ray))
            continue;
        const Instance& instance = media_.scene().description().instances[boundary.boundary->instance];
        const auto in_object = plane.coordinates.in_object(instance.world_from_object);
        cuts.clear();
        if (boundary.boundary->is_box)
            append_box_cuts(boundary.boundary->object_bounds, in_object, cuts);
        else
            append_medium_cuts(media_.scene().description(), *boundary.boundary, in_object, cuts);
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
            const bool leaves = glm::dot(cut.outward_normal, boundary.light_in_object - cut.point) > 0.0;
            crossings.push_back({near, far, a, b, c, leaves ? boundary.sigma_t : -boundary.sigma_t});
        }
    }
}
} // namespace tyndall::light_shafts
