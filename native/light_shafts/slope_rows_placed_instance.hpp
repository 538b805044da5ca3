// SPDX-License-Identifier: GPL-3.0-or-later
// Where an instance stands in the frame of slope rows, what they need of its boxes, and how rasters share the slices.
#pragma once
#include "light_shafts/slope_rows_culling.hpp"

namespace tyndall::light_shafts::slope_rows {
/// An instance in the frame's coordinates.
struct PlacedInstance {
    mat3 frame_from_object, extent_from_object;
    vec3 origin;
    float slack_m; ///< Of rounding, for a point of the mesh.

    PlacedInstance(const Frame& frame, const mat4& scene_from_object, const Bounds3& bounds) {
        frame_from_object = glm::transpose(mat3(frame.u, frame.v, frame.axis)) * mat3(scene_from_object);
        // The offset in double: an instance 60 km out, before a camera beside it, keeps its millimetres.
        const dvec3 offset = dvec3(vec3(scene_from_object[3])) - dvec3(frame.origin);
        origin = vec3(vec3(glm::dot(dvec3(frame.u), offset), glm::dot(dvec3(frame.v), offset),
                           glm::dot(dvec3(frame.axis), offset)));
        for (int c = 0; c < 3; ++c)
            extent_from_object[c] = glm::abs(frame_from_object[c]);
        const vec3 farthest = extent_from_object * glm::max(glm::abs(bounds.min), glm::abs(bounds.max));
        slack_m = 2e-6f * (glm::length(origin) + glm::length(farthest));
    }
    [[nodiscard]] SliceNeeds needs(const Culling& culling, const Bounds3& bounds, std::int32_t first,
                                   std::int32_t end) const {
        return culling.needs_of_box(frame_from_object * bounds.centre() + origin,
                                    extent_from_object * (0.5f * (bounds.max - bounds.min)) + slack_m, first, end);
    }
};

/// Consecutive slices that one thread fills: enough ranges to share the work, few enough to place most triangles once.
inline std::size_t slices_per_range(const Layout& layout) {
    constexpr std::size_t samples_per_range = std::size_t{1} << 19;
    const std::size_t range_count = 1 + layout.sample_count / samples_per_range;
    return (layout.rows.size() + range_count - 1) / range_count;
}
} // namespace tyndall::light_shafts::slope_rows
