// SPDX-License-Identifier: GPL-3.0-or-later
#include "light_shafts/map_visibility.hpp"
#include <algorithm>
#include <cmath>

namespace tyndall::light_shafts {
using namespace slope_rows;

namespace {
/// A ray in the axes of a face: start + t * step.
struct FaceRay {
    vec3 start, step;
    [[nodiscard]] vec3 at(float t) const { return start + t * step; }
};

/// Adds a lit stretch to those of the ray that began at `first`; one that goes on where the last one ends makes it longer.
void append(LitRows& rows, std::size_t first, float near_m, float far_m) {
    if (!(near_m < far_m))
        return;
    if (rows.intervals.size() > first && rows.intervals.back().far_m >= near_m)
        rows.intervals.back().far_m = std::max(rows.intervals.back().far_m, far_m);
    else
        rows.intervals.push_back({.near_m = near_m, .far_m = far_m});
}

/// The part of [near, far] where a + b t >= 0.
void clip(float a, float b, float& near, float& far) {
    if (b > 0.0f)
        near = std::max(near, -a / b);
    else if (b < 0.0f)
        far = std::min(far, -a / b);
    else if (a < 0.0f)
        far = near;
}

class Walk {
public:
    Walk(const DepthMap& map, const FaceRay& ray) : map_(map), layout_(map.texels->layout), ray_(ray) {}

    /// Appends what is lit within [near, far], in which the ray stays before the face.
    void run(float near, float far, std::size_t first, LitRows& rows) const {
        const Axis x{0, layout_.first_line, layout_.line_step}, y{1, row_edge(), layout_.slice_step};
        float t = near;
        float next_x = next(x, t, far), next_y = next(y, t, far);
        while (t < far) {
            const float end = std::min({next_x, next_y, far});
            add_texel(t, end, first, rows);
            if (next_x <= end)
                next_x = next(x, end, far);
            if (next_y <= end)
                next_y = next(y, end, far);
            t = end;
        }
    }

private:
    struct Axis {
        int index;
        float first, step;
    };
    [[nodiscard]] float row_edge() const { return layout_.first_slice - 0.5f * layout_.slice_step; }
    [[nodiscard]] float coordinate(const Axis& axis, float t) const {
        const vec3 p = ray_.at(t);
        const float along = map_.is_perspective ? p[axis.index] / p.z : p[axis.index];
        return (along - axis.first) / axis.step;
    }
    /// The first border of texels across an axis that the ray meets after t.
    [[nodiscard]] float next(const Axis& axis, float t, float far) const {
        const float here = coordinate(axis, t), there = coordinate(axis, far);
        if (!(std::abs(there - here) > 0.0f) || !std::isfinite(here) || !std::isfinite(there))
            return far;
        const bool rises = there > here;
        // A little on, so that rounding at a border cannot stop the walk there.
        float border = rises ? std::floor(here + 1e-4f) + 1.0f : std::ceil(here - 1e-4f) - 1.0f;
        for (int attempt = 0; attempt < 2; ++attempt, border += rises ? 1.0f : -1.0f) {
            if (rises ? border >= there : border <= there)
                return far;
            const float at = axis.first + border * axis.step;
            // p[i] = at, or p[i] = at * p.z
            const float a = ray_.start[axis.index] - (map_.is_perspective ? at * ray_.start.z : at);
            const float b = ray_.step[axis.index] - (map_.is_perspective ? at * ray_.step.z : 0.0f);
            if (const float found = -a / b; found > t)
                return std::min(found, far);
        }
        return far;
    }
    void add_texel(float near, float far, std::size_t first, LitRows& rows) const {
        const vec3 middle = ray_.at(0.5f * (near + far));
        const float depth = map_.is_perspective ? map_.depth_at(middle.x / middle.z, middle.y / middle.z)
                                                : map_.depth_at(middle.x, middle.y);
        if (depth != no_occluder) {
            if (map_.is_perspective) // 1 / z >= depth
                clip(1.0f - depth * ray_.start.z, -depth * ray_.step.z, near, far);
            else
                clip(ray_.start.z - depth, ray_.step.z, near, far);
        }
        append(rows, first, near, far);
    }

    const DepthMap& map_;
    const Layout& layout_;
    FaceRay ray_;
};
} // namespace

/// Of a lamp's faces: where the ray is before this one, and further along its axis than along any other's.
static void clip_to_face(const ShadowMap& map, const FaceRay& ray, float& near, float& far) {
    clip(ray.start.z, ray.step.z, near, far);
    if (!map.is_cube)
        return;
    for (int axis = 0; axis < 2; ++axis)
        for (const float side : {-1.0f, 1.0f})
            clip(ray.start.z + side * ray.start[axis], ray.step.z + side * ray.step[axis], near, far);
}

void MapVisibility::lit_intervals(std::span<const ViewRay> rays, LitRows& rows) const {
    struct Part {
        float near, far;
        const DepthMap* face;
        FaceRay ray;
    };
    std::vector<Part> parts;
    for (const ViewRay& ray : rays) {
        const std::size_t first = rows.intervals.size();
        parts.clear();
        for (const DepthMap& face : map_.faces) {
            Part part{
                ray.near_m, ray.far_m, &face, {face.axes_of(ray.origin - face.origin), face.axes_of(ray.direction)}};
            if (face.is_perspective)
                clip_to_face(map_, part.ray, part.near, part.far);
            if (part.near < part.far)
                parts.push_back(part);
        }
        std::ranges::sort(parts, {}, &Part::near);
        for (const Part& part : parts)
            Walk(*part.face, part.ray).run(part.near, part.far, first, rows);
        rows.end_ray();
    }
}
} // namespace tyndall::light_shafts
