// SPDX-License-Identifier: GPL-3.0-or-later
// The way of a directional light through fog boxes and closed meshes.
// Based on: the signed sum over crossings: a way that leaves a closed mesh at s1, s3, .. and enters it at s2, s4, ..
//           has s1 - s2 + s3 - s4 .. inside, wherever it starts.
// Bound:    a box: the lower envelope of at most 12 lines, 3 where the ray is inside. A mesh: the triangles that the
//           plane cuts.
#include "light_shafts/light_side_depth.hpp"
#include "scene/medium_cuts.hpp"
#include <algorithm>

namespace tyndall::light_shafts {
namespace {
struct Line {
    double at_zero, slope;
    [[nodiscard]] double operator()(double t) const { return at_zero + slope * t; }
};

/// Lower envelope of the lines over (near, far), cut off where it is not positive.
void append_envelope(std::span<const Line> lines, double near, double far, std::uint16_t medium,
                     std::vector<LightSideTerm>& terms) {
    const Line* lowest = lines.data();
    for (const Line& line : lines)
        if (line(near) < (*lowest)(near) || (line(near) == (*lowest)(near) && line.slope < lowest->slope))
            lowest = &line;
    while (near < far) {
        double until = far;
        const Line* next = nullptr;
        for (const Line& line : lines)
            if (line.slope < lowest->slope) { // only a flatter or falling line can get below a rising one
                const double crossing = (line.at_zero - lowest->at_zero) / (lowest->slope - line.slope);
                if (crossing < until || (next != nullptr && crossing == until && line.slope < next->slope)) {
                    until = std::max(crossing, near);
                    next = &line;
                }
            }
        double from = near, to = until; // of the part above 0
        if (lowest->slope > 0.0)
            from = std::max(from, -lowest->at_zero / lowest->slope);
        else if (lowest->slope < 0.0)
            to = std::min(to, -lowest->at_zero / lowest->slope);
        if (from < to && (*lowest)(0.5 * (from + to)) > 0.0)
            terms.push_back({from, to, lowest->at_zero, lowest->slope, medium});
        near = until;
        if (next == nullptr)
            break;
        lowest = next;
    }
}

void append_box_terms(const MediumBoundary& boundary, const ViewRay& ray, const vec3& towards_light,
                      std::vector<LightSideTerm>& terms) {
    const glm::dmat4 object_from_world(boundary.object_from_world);
    const dvec3 origin(object_from_world * glm::dvec4(dvec3(ray.origin), 1.0));
    const dvec3 direction(object_from_world * glm::dvec4(dvec3(ray.direction), 0.0));
    const dvec3 light(object_from_world * glm::dvec4(dvec3(towards_light), 0.0));
    double near = ray.near_m, far = ray.far_m;
    Line leaves[3], enters[3]; // way to the planes through which the light's line leaves and enters the box
    std::size_t count = 0;
    bool is_inside = true;
    for (int axis = 0; axis < 3; ++axis) {
        const double min = boundary.object_bounds.min[axis], max = boundary.object_bounds.max[axis];
        const double slack = 1e-6 * (max - min);
        for (const double at : {origin[axis] + near * direction[axis], origin[axis] + far * direction[axis]})
            is_inside = is_inside && at >= min - slack && at <= max + slack;
        if (light[axis] != 0.0) {
            const double exit = light[axis] > 0.0 ? max : min, entry = light[axis] > 0.0 ? min : max;
            leaves[count] = {(exit - origin[axis]) / light[axis], -direction[axis] / light[axis]};
            enters[count++] = {(entry - origin[axis]) / light[axis], -direction[axis] / light[axis]};
        } else if (direction[axis] != 0.0) { // the light runs along this slab: only points inside of it count
            const double a = (min - origin[axis]) / direction[axis], b = (max - origin[axis]) / direction[axis];
            near = std::max(near, std::min(a, b));
            far = std::min(far, std::max(a, b));
        } else if (origin[axis] < min || origin[axis] > max) {
            return;
        }
    }
    if (is_inside) {
        append_envelope({leaves, count}, near, far, boundary.medium, terms);
        return;
    }
    // min over exits - max(0, max over entries) = the least of all differences.
    Line ways[12];
    std::size_t way_count = 0;
    for (std::size_t exit = 0; exit < count; ++exit) {
        ways[way_count++] = leaves[exit];
        for (std::size_t entry = 0; entry < count; ++entry)
            ways[way_count++] = {leaves[exit].at_zero - enters[entry].at_zero,
                                 leaves[exit].slope - enters[entry].slope};
    }
    append_envelope({ways, way_count}, near, far, boundary.medium, terms);
}

/// One cut of the boundary: the way to it is a term on the part of the ray that it stands over, as seen from the light.
void append_cut_term(CutSegment<double> cut, const DirectionalPlane& plane, double sign, const ViewRay& ray,
                     std::uint16_t medium, std::vector<LightSideTerm>& terms) {
    if (cut.y0 <= 0.0 && cut.y1 <= 0.0)
        return;
    if (cut.y0 > cut.y1)
        cut = {cut.x1, cut.y1, cut.x0, cut.y0};
    if (cut.y0 < 0.0) // the part beyond the ray, as seen from the light
        cut = {(cut.x0 * cut.y1 - cut.x1 * cut.y0) / (cut.y1 - cut.y0), 0.0, cut.x1, cut.y1};
    const double cotangent = plane.cosine / plane.sine;
    const double t0 = cut.x0 - cotangent * cut.y0, t1 = cut.x1 - cotangent * cut.y1;
    const double near = std::max<double>(std::min(t0, t1), ray.near_m);
    const double far = std::min<double>(std::max(t0, t1), ray.far_m);
    if (!(near < far))
        return;
    const double slope = (cut.y1 - cut.y0) / (plane.sine * (t1 - t0));
    terms.push_back({near, far, sign * (cut.y0 / plane.sine - slope * t0), sign * slope, medium});
}

void append_mesh_terms(const Media& media, const MediumBoundary& boundary, const ViewRay& ray,
                       const vec3& towards_light, std::vector<LightSideTerm>& terms) {
    const SceneDescription& scene = media.scene().description();
    const Instance& instance = scene.instances[boundary.instance];
    const DirectionalPlane plane = plane_towards(ray.origin, ray.direction, towards_light);
    const dvec3 light(vec3(boundary.object_from_world * vec4(towards_light, 0.0f)));
    thread_local std::vector<MediumCut> cuts;
    cuts.clear();
    append_medium_cuts(scene, boundary, plane.coordinates.in_object(instance.world_from_object), cuts);
    for (const MediumCut& cut : cuts)
        append_cut_term(cut.segment, plane, glm::dot(cut.outward_normal, light) > 0.0 ? 1.0 : -1.0, ray,
                        boundary.medium, terms);
}
} // namespace

void append_light_side_terms(const Media& media, const MediumBoundary& boundary, const ViewRay& ray,
                             const vec3& towards_light, std::vector<LightSideTerm>& terms) {
    if (boundary.is_box)
        append_box_terms(boundary, ray, towards_light, terms);
    else
        append_mesh_terms(media, boundary, ray, towards_light, terms);
}
} // namespace tyndall::light_shafts
