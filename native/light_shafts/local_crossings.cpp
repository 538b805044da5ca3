// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/local_crossings.hpp"
#include "scene/medium_cuts.hpp"
#include <algorithm>
#include <array>
#include <optional>

namespace tyndall::light_shafts {
LightSideBoundaries::LightSideBoundaries(const Media& media, const vec3& light_position)
    : media_(media), light_position_(light_position) {
    for (const MediumBoundary& boundary : media.boundaries()) {
        MediumSet alone;
        alone.insert(boundary.medium);
        boundaries_.push_back(
            {.boundary = &boundary,
             .light_in_object = dvec3(glm::dmat4(boundary.object_from_world) * glm::dvec4(dvec3(light_position), 1.0)),
             .sigma_t = dvec3(media.sigma_t_per_m(alone)),
             .holds_light = boundary.is_box && holds(boundary, light_position)});
        all_hold_light_ = all_hold_light_ && boundaries_.back().holds_light;
    }
}

static bool holds(const MediumBoundary& boundary, const ViewRay& ray) {
    return holds(boundary, ray.origin + ray.near_m * ray.direction, rounding_of_ends) &&
           holds(boundary, ray.origin + ray.far_m * ray.direction, rounding_of_ends);
}

bool LightSideBoundaries::is_clear(const LocalRays& rays, std::size_t index, const ViewRay& part) const {
    return all_hold_light_ &&
           (rays.is_in_all_boxes(index) || std::ranges::all_of(boundaries_, [&](const Boundary& boundary) {
                return holds(*boundary.boundary, part);
            }));
}

/// From a box that holds the ray, the light's way leaves through the face that it meets first. Where two faces are met at
/// the same share of the way, the ray is at the root of a linear equation.
void LightSideBoundaries::append_box_crossings(const Boundary& boundary, const ViewRay& ray,
                                               std::vector<LocalCrossing>& crossings) {
    const Bounds3& box = boundary.boundary->object_bounds;
    const glm::dmat4 object_from_world(boundary.boundary->object_from_world);
    const dvec3 origin(object_from_world * glm::dvec4(dvec3(ray.origin), 1.0));
    const dvec3 along(object_from_world * glm::dvec4(dvec3(ray.direction), 0.0));
    struct Face {
        dvec2 n, d;
    } faces[3];
    std::size_t count = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double light = boundary.light_in_object[axis], low = box.min[axis], high = box.max[axis];
        if (light >= low && light <= high)
            continue;
        const double sign = light > high ? 1.0 : -1.0, at = light > high ? high : low;
        faces[count++] = {{sign * (at - origin[axis]), -sign * along[axis]},
                          {sign * (light - origin[axis]), -sign * along[axis]}};
    }
    std::array<double, 5> ends{ray.near_m, ray.far_m};
    std::size_t end_count = 2;
    const auto first_met_before = [](const Face& a, const Face& b) { // a line: positive where b is met first
        return dvec2(a.n.x * b.d.x - b.n.x * a.d.x, a.n.x * b.d.y + a.n.y * b.d.x - b.n.x * a.d.y - b.n.y * a.d.x);
    };
    for (std::size_t a = 0; a < count; ++a)
        for (std::size_t b = a + 1; b < count; ++b) {
            const dvec2 line = first_met_before(faces[a], faces[b]);
            const double root = -line.x / line.y;
            if (!(root > ray.near_m && root < ray.far_m)) // nor a NaN
                continue;
            std::size_t at = end_count++;
            for (; ends[at - 1] > root; --at)
                ends[at] = ends[at - 1];
            ends[at] = root;
        }
    for (std::size_t end = 0; end + 1 < end_count; ++end) {
        const double middle = 0.5 * (ends[end] + ends[end + 1]);
        const Face* first = faces;
        for (const Face* face = faces + 1; face < faces + count; ++face) {
            const dvec2 line = first_met_before(*first, *face);
            if (line.x + line.y * middle > 0.0)
                first = face;
        }
        crossings.push_back({ends[end], ends[end + 1], first->n, first->d, boundary.sigma_t});
    }
}

void LightSideBoundaries::append_crossings(const ViewRay& ray, std::vector<LocalCrossing>& crossings) const {
    std::optional<LocalPlane> plane;
    for (const Boundary& boundary : boundaries_) {
        const bool holds_ray = boundary.boundary->is_box && holds(*boundary.boundary, ray);
        if (holds_ray && boundary.holds_light)
            continue;
        if (holds_ray) {
            append_box_crossings(boundary, ray, crossings);
            continue;
        }
        if (!plane)
            plane = plane_through(ray.origin, ray.direction, light_position_);
        append_cut_crossings(boundary, ray, *plane, crossings);
    }
}

void LightSideBoundaries::append_cut_crossings(const Boundary& boundary, const ViewRay& ray, const LocalPlane& plane,
                                               std::vector<LocalCrossing>& crossings) const {
    thread_local std::vector<MediumCut> cuts;
    cuts.clear();
    const Instance& instance = media_.scene().description().instances[boundary.boundary->instance];
    const auto in_object = plane.coordinates.in_object(instance.world_from_object);
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
        // The line a x + b y = c, seen from (t, 0) towards (light_x, light_y).
        crossings.push_back({near,
                             far,
                             {c, -a},
                             {a * plane.light_x + b * plane.light_y, -a},
                             leaves ? boundary.sigma_t : -boundary.sigma_t});
    }
}
} // namespace tyndall::light_shafts
