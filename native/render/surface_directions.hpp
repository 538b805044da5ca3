// SPDX-License-Identifier: GPL-3.0-or-later
// Directions from a surface point in which light counts: by its lobes and by the cosine, each as often as it sends light.
#pragma once
#include "core/sampling.hpp"
#include "render/surface_point.hpp"
#include "shading/lobes/lobe_set.hpp"
#include <algorithm>

namespace tyndall::render {
/// By which the world's irradiance, and what is gathered, counts from a unit direction that was drawn: 0 where nothing of it
/// comes back, nor of what is no direction. Behind the point's normal, but above its surface, LobeSet's least, which gloss
/// around a normal of its own takes back. From lamps behind a smooth normal nothing comes, as in Cycles.
[[nodiscard]] inline float counted_cosine(const SurfacePoint& point, const LobeSet& lobes, const vec3& direction) {
    const float cosine = glm::dot(point.shading.shading_normal, direction);
    if (cosine > 0.0f)
        return cosine;
    return lobes.reflects_from_behind() && !point.is_below_surface(direction) ? LobeSet::least_cosine : 0.0f;
}

class SurfaceDirections {
public:
    /// Both outlive it.
    SurfaceDirections(const SurfacePoint& point, const LobeSet& lobes)
        : lobes_(lobes), normal_(point.shading.shading_normal),
          p_lobes_(lobes.share_of_directions(point.lambert_share)) {}

    [[nodiscard]] bool is_by_lobes(vec2 u) const { return u.x < p_lobes_; }
    /// By lobes alone, or nearly so.
    [[nodiscard]] bool is_gloss() const { return p_lobes_ == LobeSet::most_share; }
    /// A unit direction, which may lie below the horizon.
    [[nodiscard]] vec3 sample(vec2 u) const {
        if (is_by_lobes(u))
            return lobes_.sample({even_within(u.x, 0.0f, p_lobes_), u.y});
        return from_frame(normal_, sample_cosine_hemisphere({even_within(u.x, p_lobes_, 1.0f - p_lobes_), u.y}));
    }
    [[nodiscard]] float pdf_per_sr(const vec3& direction) const {
        const float by_cosine = cosine_hemisphere_pdf_per_sr(std::max(glm::dot(normal_, direction), 0.0f));
        return (1.0f - p_lobes_) * by_cosine + (p_lobes_ > 0.0f ? p_lobes_ * lobes_.pdf_per_sr(direction) : 0.0f);
    }

private:
    const LobeSet& lobes_;
    const vec3& normal_;
    float p_lobes_;
};
} // namespace tyndall::render
