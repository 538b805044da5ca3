// SPDX-License-Identifier: GPL-3.0-or-later
// Boundaries of media between a view ray and a local light, as lines in the plane of both.
// Bound:    a fog box that holds both: none, by two tests of a point. Another box: at most 6 lines in closed form. A
//           mesh: one per triangle that the plane cuts.
#pragma once
#include "light_shafts/light_shafts.hpp"
#include "scene/media.hpp"
#include "scene/plane_cut.hpp"
#include <span>
#include <vector>

namespace tyndall::light_shafts {
/// The line a x + b y = c, between the light and a part of the ray.
struct LocalCrossing {
    double near_m, far_m; ///< Where on the ray the light casts it.
    double a, b, c;
    dvec3 signed_sigma_t; ///< Positive where the way to the light leaves the medium.
};

/// The boundaries of a scene's media as one light sees them.
class LightSideBoundaries {
public:
    LightSideBoundaries(const Media& media, const vec3& light_position);
    /// Nothing lies between the light and this part of a ray.
    [[nodiscard]] bool is_clear(const ViewRay& ray) const;
    /// Appends what lies between the light and the ray.
    void append_crossings(const ViewRay& ray, const LocalPlane& plane, std::vector<LocalCrossing>& crossings) const;

private:
    struct Boundary {
        const MediumBoundary* boundary;
        dvec3 light_in_object;
        dvec3 sigma_t;
        bool holds_light; ///< A box that does.
    };
    const Media& media_;
    std::vector<Boundary> boundaries_;
};
} // namespace tyndall::light_shafts
