// SPDX-License-Identifier: GPL-3.0-or-later
#include "render/shadow_terminator.hpp"
#include <algorithm>
#include <array>
#include <limits>

namespace tyndall::render {
namespace {
/// Sine of the angle above the horizon at which the lift begins to fade: Blender's default for every object.
constexpr float horizon_sine = 0.1f;

/// Share of the full lift, [0, 1].
float lift_share(float shading_cosine, float geometric_cosine) {
    const float above_horizon = shading_cosine < horizon_sine ? 0.5f * (geometric_cosine + shading_cosine)
                                                              : 0.5f * (geometric_cosine + horizon_sine);
    return std::clamp(2.0f * (1.0f - above_horizon / horizon_sine), 0.0f, 1.0f);
}

struct SmoothTriangle {
    std::array<vec3, 3> corners, normals; ///< Scene space: what a scale stretches bulges by its own normals.
    vec3 point;
    std::array<float, 3> barycentrics;

    /// How far the quadratic surface through the corners, at right angles to their normals, lies above the triangle,
    /// times 2: each edge bulges by what its normals turn along it.
    [[nodiscard]] float bulge() const {
        float sum = 0.0f;
        for (std::size_t i = 0; i < 3; ++i) {
            const std::size_t j = (i + 1) % 3;
            sum += glm::dot(normals[j] - normals[i], corners[j] - corners[i]) * barycentrics[i] * barycentrics[j];
        }
        return sum;
    }
    /// Height above the point of the lowest of three planes, each at right angles to a corner's normal (times `side`)
    /// and pushed out until the triangle lies below it.
    [[nodiscard]] float lowest_envelope(float side) const {
        float lowest = std::numeric_limits<float>::infinity();
        for (const vec3& normal : normals) {
            float highest = 0.0f; // the point itself lies in the triangle
            for (const vec3& corner : corners)
                highest = std::max(highest, side * glm::dot(corner - point, normal));
            lowest = std::min(lowest, highest);
        }
        return lowest;
    }
};
} // namespace

/// Above the steps of the surface that the cells are: those of a thin one have their centres within half of `step` of it,
/// measured along its normal, and reach `reach` beyond these.
static vec3 lift_over_steps(const Scene& scene, const PlacedShape& placed, const Hit& hit, const ShadingPoint& point,
                            const vec3& towards_light) {
    if (glm::dot(point.shading_normal, towards_light) <= 0.0f)
        return vec3(0.0f);
    const Bounds3 box =
        scene.description().shapes[placed.shape_index]->cells()->box(hit.cell); // strands are not smooth
    const vec3 size = box.max - box.min;
    float reach = 0.0f, step = 0.0f;
    for (int axis = 0; axis < 3; ++axis) {
        const float edge = std::abs(glm::dot(point.shading_normal, vec3(placed.world_from_object[axis]) * size[axis]));
        reach += 0.5f * edge;
        step = std::max(step, edge);
    }
    const vec3 centre(placed.world_from_object * vec4(0.5f * (box.min + box.max), 1.0f));
    const float height = glm::dot(point.shading_normal, point.position - centre);
    return std::max(reach + step - height, 0.0f) * point.shading_normal;
}

vec3 terminator_lift(const Scene& scene, const Hit& hit, const ShadingPoint& point, const vec3& towards_light) {
    if (!scene.is_smooth(hit.instance))
        return vec3(0.0f);
    if (const PlacedShape* placed = scene.placed_shape(hit.instance))
        return lift_over_steps(scene, *placed, hit, point, towards_light);
    const SceneDescription& description = scene.description();
    const Instance& instance = description.instances[hit.instance];
    const SharedMeshArrays& arrays = description.meshes[instance.mesh_index]->arrays();
    const vec3 viewed_normal = point.is_backface ? -hit.geometric_normal : hit.geometric_normal;
    const float share =
        lift_share(glm::dot(point.shading_normal, towards_light), glm::dot(viewed_normal, towards_light));
    if (share == 0.0f)
        return vec3(0.0f);
    SmoothTriangle triangle;
    triangle.barycentrics = {1.0f - hit.barycentrics.x - hit.barycentrics.y, hit.barycentrics.x, hit.barycentrics.y};
    triangle.point = vec3(0.0f);
    vec3 lift_direction(0.0f);
    for (int corner = 0; corner < 3; ++corner) {
        const auto i = static_cast<std::size_t>(corner);
        triangle.corners[i] =
            mat3(instance.world_from_object) * arrays.positions[arrays.triangles[hit.triangle][corner]];
        const vec3 normal =
            scene.normal_in_scene(hit.instance, arrays.corner_normals[3 * std::size_t{hit.triangle} + i]);
        const float length = glm::length(normal);
        if (!(length > 0.0f)) // flat at that corner
            return vec3(0.0f);
        triangle.normals[i] = normal / length;
        triangle.point += triangle.barycentrics[i] * triangle.corners[i];
        lift_direction += triangle.barycentrics[i] * triangle.normals[i];
    }
    const bool is_outer_side = glm::dot(lift_direction, viewed_normal) > 0.0f;
    const float height = is_outer_side ? std::max(triangle.lowest_envelope(1.0f), 0.5f * triangle.bulge())
                                       : std::min(-triangle.lowest_envelope(-1.0f), 0.5f * triangle.bulge());
    return share * height * lift_direction;
}
} // namespace tyndall::render
